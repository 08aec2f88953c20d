"""Parses XML of robot files, which often break rules of the standard."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from hqp import InvalidInput

#: Comments (dashes inside are accepted) and CDATA; the declaration; the first element; a namespace without prefix; an
#: ampersand that does not begin an entity.
COMMENT = re.compile(r"<!--.*?-->|<!\[CDATA\[.*?\]\]>", re.DOTALL)
NAMESPACE = re.compile(r"\sxmlns\s*=\s*(\"[^\"]*\"|'[^']*')")
DECLARATION = re.compile(r"\s*<\?xml[^>]*\?>")
ENCODING = re.compile(r"\s*<\?xml[^>]*?encoding\s*=\s*[\"']([\w.:-]+)[\"']")
FIRST = re.compile(r"<\s*(?:\w+:)?([A-Za-z_][\w.-]*)")
AMPERSAND = re.compile(r"&(?!(?:[\w.:-]+|#\w+);)")
#: Encodings by the first bytes of a file.
MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}


def text_of(path: Path, what: str) -> str:
    """The text of a file, in the encoding it declares, or else in UTF-8.

    Raises
    ------
    InvalidInput
        If it cannot be read, or is not in that encoding.
    """
    try:
        data = path.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        raise InvalidInput(f"{what} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    encoding = next((name for mark, name in MARKS.items() if data.startswith(mark)), "")
    if not encoding:
        declared = ENCODING.match(data[:200].decode("latin-1"))
        encoding = declared.group(1) if declared else "utf-8"
    try:
        return data.decode(encoding)
    except (LookupError, UnicodeDecodeError):
        raise InvalidInput(f"{what} is not in {encoding}; its first line is to name its encoding") from None


def root_of(path: Path, what: str) -> str:
    """The name of the first element of an XML file; empty if there is none.

    Raises
    ------
    InvalidInput
        If the file cannot be read.
    """
    try:
        text = text_of(path, what)
    except InvalidInput:
        if not path.is_file():
            raise
        text = path.read_bytes().decode("latin-1")  # names of elements are ASCII
    first = FIRST.search(DECLARATION.sub("", COMMENT.sub("", text), count=1))
    return first.group(1) if first else ""


def parsed(path: Path, what: str) -> Element:
    """The root element of an XML file. Namespaces without a prefix are ignored.

    Raises
    ------
    InvalidInput
        If it cannot be read, or is not XML; the message gives the line.
    """
    text = COMMENT.sub(lambda comment: "\n" * comment.group().count("\n"), text_of(path, what))
    text = NAMESPACE.sub("", AMPERSAND.sub("&amp;", DECLARATION.sub("", text, count=1).strip()))
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise InvalidInput(f"{what} is no valid XML: {error}") from None


def written(root: Element, what: str) -> str:
    """The XML text of an element and its contents.

    Raises
    ------
    InvalidInput
        If elements are nested too deeply.
    """
    try:
        return ElementTree.tostring(root, encoding="unicode")
    except RecursionError:
        raise InvalidInput(f"{what}: its elements are nested too deeply to be read") from None
