"""The page of a verification report: one HTML file with its own data in it, sealed by a hash over all of it."""

from __future__ import annotations

import hashlib
import json
import re

from conrod.errors import InvalidInput
from conrod.report.html.markdown import Place, html_of
from conrod.report.html.page import Section, document
from conrod.report.saved import plain, restore
from conrod.report.template import rendered
from conrod.report.verification.findings import Verification

MARK = "conrod-verification"
UNSEALED = "0" * 64
SEAL = re.compile(rf'<meta name="{MARK}" content="sha256:([0-9a-f]{{64}})">'.encode())
DATA = re.compile(rf'<script type="application/json" id="{MARK}-data">(.*?)</script>', re.DOTALL)


def sealed_page(found: Verification) -> bytes:
    """The report as a file: the hash of it, with zeros where the hash stands, stands in its head and on the page."""
    text = rendered(
        "verification", found=found, digest=UNSEALED, measured=len(found.sections["validation"].sentences) > 1
    )
    place = Place("verification", 0, lambda name, alt: None, lambda name: None)
    html = document([Section("verification", f"Verification report: {found.subject}", html_of(text, place))])
    # In a script nothing but its end is markup.
    data = json.dumps(plain(found), ensure_ascii=False).replace("<", "\\u003c")
    html = html.replace("</head>", f'<meta name="{MARK}" content="sha256:{UNSEALED}">\n</head>', 1)
    head, end = html.rsplit("</body>", 1)
    html = f'{head}<script type="application/json" id="{MARK}-data">{data}</script>\n</body>{end}'
    return html.replace(UNSEALED, hashlib.sha256(html.encode()).hexdigest()).encode()


def seal_of(page: bytes) -> str | None:
    """The hash that a page is sealed by; None where it is not as it was written, to the last byte.

    Raises:
        InvalidInput: it is no verification report.
    """
    if MARK.encode() not in page:
        raise InvalidInput("it is no verification report of conrod")
    found = SEAL.search(page)
    if found is None or hashlib.sha256(page.replace(found[1], UNSEALED.encode())).hexdigest().encode() != found[1]:
        return None
    return found[1].decode()


def data_of(page: bytes) -> Verification:
    """The contents of an unchanged report.

    Raises:
        InvalidInput: it is of another version of conrod.
    """
    found = DATA.search(page.decode())
    if found is None:
        raise InvalidInput("it has no data of a verification report")
    return restore(Verification, json.loads(found[1]))
