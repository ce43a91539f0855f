"""Decode text of users' files in the encodings that tools write: UTF-8, UTF-16, and those of Windows."""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from conrod.errors import InvalidInput

# Marks that a text may begin with, the longer ones first.
MARKS = {
    codecs.BOM_UTF32_LE: ("UTF-32", "utf-32"),
    codecs.BOM_UTF32_BE: ("UTF-32", "utf-32"),
    codecs.BOM_UTF8: ("UTF-8", "utf-8-sig"),
    codecs.BOM_UTF16_LE: ("UTF-16", "utf-16"),
    codecs.BOM_UTF16_BE: ("UTF-16", "utf-16"),
}
MAX_SAMPLE_BYTES = 64 * 1024  # bytes of lines with other than ASCII letters that the encoding is derived from
MIN_PLAUSIBILITY = 0.5  # mean share below which an encoding is not taken to be that of a text
# A text of numbers in UTF-16 has a zero in nearly every second byte, and nearly none in the others.
MIN_ZERO_SHARE, MAX_ZERO_SHARE = 0.4, 0.1
NON_ASCII = re.compile(r"[^\x00-\x7f]+")
# Signs that stand beside words and units in western texts: degree, micro, powers, plus or minus, dot, times,
# divided by, section, euro, dashes, quotes, ellipsis, ordinals.
SIGNS = "\xb0\xb5\xb2\xb3\xb1\xb7\xd7\xf7\xa7\u20ac\u2013\u2014\u2018\u2019\u201c\u201d\u2026\xaa\xba"


@dataclass(frozen=True)
class Encoding:
    """An encoding by the name that users know and Python's.

    Attributes:
        plausible: how much a run of letters other than ASCII looks like a text, from what stands before and after it.
    """

    name: str
    codec: str
    plausible: Callable[[str, str, str], float] | None


def decode_text(content: bytes, wanted: Sequence[str] = ()) -> tuple[str, str]:
    """Decode bytes to text; return the text and the name of its encoding.

    Where bytes alone do not tell, the encoding is that in which the text has the `wanted` words, or else that in
    which its letters are the most plausible ones.

    Args:
        wanted: what should be found in the text, such as headings that a user names.

    Raises:
        InvalidInput: the bytes are no text in any of these encodings.
    """
    for mark, (name, codec) in MARKS.items():
        if content.startswith(mark):
            return _decode_marked(content, name, codec), name
    if b"\0" in content:
        return _decode_unmarked_utf16(content), "UTF-16"
    try:
        return content.decode("utf-8"), "UTF-8"
    except UnicodeDecodeError:
        found = _most_plausible(content, [text for text in wanted if not text.isascii()])
    return content.decode(found.codec, errors="replace"), found.name


def _decode_marked(content: bytes, name: str, codec: str) -> str:
    """Decode text that begins with a byte order mark; raises InvalidInput at a byte that is none."""
    try:
        return content.decode(codec)
    except UnicodeDecodeError as error:
        raise InvalidInput(f"it is no text in {name}, as which it begins: byte {error.start} cannot be read") from None


def _decode_unmarked_utf16(content: bytes) -> str:
    """Decode UTF-16 without a byte order mark; raises InvalidInput where zero bytes have another cause."""
    for codec, high in (("utf-16-le", 1), ("utf-16-be", 0)):
        zeros = [content[place::2].count(0) / max(len(content) // 2, 1) for place in (high, 1 - high)]
        if zeros[0] >= MIN_ZERO_SHARE and zeros[1] <= MAX_ZERO_SHARE and len(content) % 2 == 0:
            try:
                text = content.decode(codec)
            except UnicodeDecodeError:
                continue
            if "\0" not in text:
                return text
    raise InvalidInput("it is no table of text: it holds zero bytes; save a sheet as CSV")


def _most_plausible(content: bytes, wanted: Sequence[str]) -> Encoding:
    """The encoding that yields the wanted words or, without any, the most plausible letters."""
    sample = b"\n".join(line for line in content.splitlines() if not line.isascii())[:MAX_SAMPLE_BYTES]
    texts = {}
    for encoding in ENCODINGS:
        try:
            texts[encoding.name] = sample.decode(encoding.codec)
        except UnicodeDecodeError as error:
            # The sample may end within a letter.
            if error.start > len(sample) - 4 and len(sample) == MAX_SAMPLE_BYTES:
                texts[encoding.name] = sample[: error.start].decode(encoding.codec)
    possible = [encoding for encoding in ENCODINGS if encoding.name in texts]
    having = [one for one in possible if wanted and all(text in texts[one.name] for text in wanted)]
    if having:
        return having[0]
    shares = {one.name: _mean_plausibility(texts[one.name], one.plausible) for one in possible if one.plausible}
    best = max(possible, key=lambda one: shares.get(one.name, 0.0), default=WESTERN)
    return best if shares.get(best.name, 0.0) >= MIN_PLAUSIBILITY else WESTERN


def _mean_plausibility(text: str, plausible: Callable[[str, str, str], float]) -> float:
    """Mean plausibility of the letters outside ASCII, each run of them weighted by its length."""
    total, count = 0.0, 0
    for run in NON_ASCII.finditer(text):
        before, after = text[run.start() - 1 : run.start()], text[run.end() : run.end() + 1]
        total += len(run[0]) * plausible(run[0], before, after)
        count += len(run[0])
    return total / count if count else 0.0


# -- how plausible letters are -----------------------------------------------------------------------------------------


def _western_plausibility(run: str, before: str, after: str) -> float:
    """Plausibility of a run of letters in Western text, from 0 to 1.

    Accented letters stand singly or in pairs within lower-case words, signs next to words.
    """
    if all(letter in SIGNS for letter in run):
        return 1.0 if len(run) <= 2 else 0.5
    if not all(letter.isalpha() and letter < "\u0180" for letter in run) or len(run) > 2:
        return 0.0
    if any(letter.isupper() for letter in run) and (before.islower() or before.isdigit()):
        return 0.0  # no word goes on with a capital letter
    beside = before.isalpha() or after.isalpha()
    return (1.0 if len(run) == 1 else 0.7) if beside else 0.6


def _chinese_plausibility(run: str, before: str, after: str) -> float:
    """Mean plausibility of the letters of a run as Chinese text."""
    return sum(map(_hanzi_plausibility, run)) / len(run)


def _hanzi_plausibility(letter: str) -> float:
    """Plausibility of a letter in Chinese text, from 0 to 1.

    The 3755 characters of level 1 of GB 2312 make up nearly all of a Chinese text.
    """
    try:
        lead = letter.encode("gb2312")[0]
    except UnicodeEncodeError:
        return 0.0
    return 1.0 if 0xB0 <= lead <= 0xD7 else 0.3 if lead > 0xD7 else 0.6


def _japanese_plausibility(run: str, before: str, after: str) -> float:
    """Mean plausibility of the letters of a run as Japanese text."""
    return sum(map(_kana_or_kanji_plausibility, run)) / len(run)


def _kana_or_kanji_plausibility(letter: str) -> float:
    """Plausibility of a letter in Japanese text, from 0 to 1.

    Kana and the 2965 characters of level 1 of JIS X 0208 make up nearly all of a Japanese text.
    """
    if "\u3040" <= letter <= "\u30ff":
        return 1.0
    if "\uff61" <= letter <= "\uff9f":
        return 0.3  # of half width: any single byte
    lead = letter.encode("cp932")[0]
    return 0.9 if 0x88 <= lead <= 0x97 else 0.6 if lead < 0x88 else 0.2


WESTERN = Encoding("Windows-1252", "cp1252", _western_plausibility)
# Of two that are as plausible the first is meant. The last ones look like others: they are taken where no other
# has what is wanted of the text.
ENCODINGS = (
    WESTERN,
    Encoding("GBK", "gb18030", _chinese_plausibility),
    Encoding("Shift-JIS", "cp932", _japanese_plausibility),
    Encoding("Big5", "big5", None),
    Encoding("EUC-KR", "cp949", None),
    Encoding("EUC-JP", "euc_jp", None),
    Encoding("Windows-1251", "cp1251", None),
    Encoding("Windows-1250", "cp1250", None),
)
