"""Headings are decoded as they were written, in the encodings of spreadsheets and loggers of all countries."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from command_line import conrod
from table_files import read_file

from conrod import InvalidInput
from conrod.scenes import Saw
from conrod.user_files.encodings import decode_text

CASES = Path(__file__).parents[1] / "data" / "cases"
NUMBERS = "0,100\n0.25,84.6804\n" * 20
# Encoding -> headings, each of which tells the encoding alone.
HEADINGS = {
    "gbk": ["时间 t,位移: 摇杆 x", "时间(s),角度(°),速度", "x轴,y轴", "t,角速度 [rad/s]", "曲柄转角,滑块位移,加速度"],
    "cp932": ["時間 [s],角度 [度],位置 x", "タイム,変位", "速度,加速度", "x座標,t", "時刻,クランク角", "時刻,角度,ﾀｲﾑ"],
    "cp1252": ["t,crank angle [°]", "Größe,Länge,µm", "déplacé,vitesse à", "Ángulo,posición", "élève,Ø [mm]",
               "a [m/s²]", "Öffnung,Maßstäbe", "naïve \u2013 yes", "NÃO,AÇÃO"],
    "latin-1": ["t,Kurbelwinkel [°]", "t,C.x [µm]"],
    "utf-8": ["时间 t,位移: 摇杆 x", "t,θ [°]"],
    "utf-8-sig": ["时间 t", "time,C.x"],
    "utf-16": ["时间 t,位移: 摇杆 x", "time,C.x", "t,θ [°]"],
    "utf-16-le": ["时间 t,位移: 摇杆 x", "time,C.x"],
    "utf-16-be": ["时间 t,位移: 摇杆 x", "time,C.x"],
    "utf-32": ["时间 t"],
}  # fmt: skip
# Encodings that look like others: known by a heading that a user names.
NAMED = {"big5": "時間", "cp949": "시간", "euc_jp": "時間", "cp1251": "время", "cp1250": "čas", "gbk": "摇杆 x"}


@pytest.mark.parametrize("encoding", HEADINGS)
def test_headings_tell_the_encoding(encoding: str) -> None:
    for heading in HEADINGS[encoding]:
        text = f"{heading}\n{NUMBERS}"
        assert decode_text(text.encode(encoding))[0] == text


@pytest.mark.parametrize("encoding", NAMED)
def test_named_heading_decides_between_similar_encodings(encoding: str) -> None:
    text = f"{NAMED[encoding]},x\n{NUMBERS}"
    assert decode_text(text.encode(encoding), ["x", NAMED[encoding]])[0] == text
    # Named without being there, it tells nothing.
    assert decode_text("Länge,x\n".encode("cp1252"), [NAMED[encoding]]) == ("Länge,x\n", "Windows-1252")


@pytest.mark.parametrize("content", [b"t,x\n0,1\n\x001,2\n", b"\xff\xfet", b"\0\0\0\0", b"\xef\xbb\xbf\xff\xfe"])
def test_what_is_no_text_is_refused(content: bytes) -> None:
    with pytest.raises(InvalidInput, match=r"zero bytes|cannot be read"):
        decode_text(content)


@pytest.mark.parametrize("encoding", ["gbk", "utf-16", "utf-16-le", "utf-8"])
def test_a_column_is_named_as_it_is_written(encoding: str, tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_bytes("时间 t\uff08ms\uff09,位移: 摇杆 x,速度 x [mm/s]\n0,100,7\n2,50,7\n".encode(encoding))
    found = read_file(file, Saw(), ["C.x=位移: 摇杆 x", "C.vx=速度 x"], ["mm"])
    assert {column.name: column.heading for column in found.columns} == {
        "time": "时间 t\uff08ms\uff09", "C.x": "位移: 摇杆 x", "C.vx": "速度 x [mm/s]",
    }  # fmt: skip
    assert found.values["time"].tolist() == [0.0, 0.002]
    assert found.values["C.x"].tolist() == [0.1, 0.05]


def test_gbk_table_is_judged_by_its_heading_as_written(tmp_path: Path) -> None:
    for name in ("rocker-gbk.csv", "rocker.toml"):
        shutil.copy(CASES / name, tmp_path)
    typed = ("check", "rocker-gbk.csv", "--scene", "rocker.toml", "--unit", "mm")
    done = conrod(*typed, "--column", "B.x=位移: 摇杆 x", "--tolerance", "position=1e-6", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (
        "within tolerance: position 5.6e-7 (4.6e-5 mm) <= 1e-6 (8.2e-5 mm); not judged: position of B.y, velocity"
        in done.stdout
    )
    assert "(text, separated by commas, decimal points, GBK)" in done.stdout
    assert "位移: 摇杆 x" in done.stdout
    done = conrod(*typed, "--column", "B.x=位移 x", cwd=tmp_path)
    assert done.returncode == 2
    assert "did you mean '位移: 摇杆 x'?" in done.stderr
