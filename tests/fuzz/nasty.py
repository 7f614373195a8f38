"""Nasty values: what a file or a command line may say in place of something sensible."""

from __future__ import annotations

DEEP = 20_000
"""Levels of nesting that no honest file has."""

NUMBERS = (
    "nan", "NaN", "inf", "-inf", "Infinity", "-Infinity", "1e308", "-1e308", "1.7976931348623157e308", "1e999",
    "1e-320", "5e-324", "1e-317", "0", "-0.0", "-1", "0.5", "1e9", "2147483648", "9223372036854775808",
    "99999999999999999999", "1" + "0" * 400, "9" * 5000, "0x10", "1_000", "١٢",
)  # fmt: skip
"""Numbers at and beyond the edge of every type, and what only looks like one."""

WORDS = (
    "", " ", ".", "..", "../outside", "../../../outside", "x" * 10_000, "é" * 300, "\x1b[31mred", "a\nb", "a\rb",
    "a\tb", "[/b]", "[bold]", "$x_{", "<script>alert(1)</script>", "<!--<script>", "=cmd|' /C calc'!A0", "|", "`", "%s",
    "{}", "\ud800", "\u202e", "\x00", "nowhere", "folder", "os:nothing", "os:", ":x", "json:JSONDecoder",
    "builtins:print",
)  # fmt: skip
"""Words that are markup, paths, escapes, nothing or far too long."""

FILES = ("zero", "fifo", "folder", "missing.json", "self")
"""Links to a device and to itself, a FIFO and a folder that lie beside every case."""

JSON = (
    *(word for word in NUMBERS if word not in ("0x10", "1_000", "١٢")),
    "null", "true", "[]", "{}", "[[]]", '[{"a": 1}]', '"text"', "[NaN]", "[1e308, 1e308]", r'"\ud800"', r'"\u0000"',
    r'"\u001b[31m"', '"' + "x" * 10_000 + '"', "[" * 60_000, "[" * DEEP + "]" * DEEP, '{"a":' * DEEP + "1" + "}" * DEEP,
)  # fmt: skip
"""JSON texts, valid or nearly."""

TOML = (
    *NUMBERS, "true", "[]", "{}", "[[]]", "[1, 'a']", "{a = 1}", "[[1, 2], [3]]", "1979-05-27T07:32:00Z", "[nan, nan]",
    '"' + "x" * 10_000 + '"', r'"\u001b[31m"', r'"\u0000"', "[" * DEEP, "[" * DEEP + "]" * DEEP, '""', "'.'",
    "'folder'", "'zero'", "'fifo'", "'self'", "'../../../outside'", "'[/b]'", "'json:JSONDecoder'",
)  # fmt: skip
"""TOML texts, valid or nearly."""

BYTES = (
    b"\x00", b"\xff\xfe", b"\xed\xa0\x80", b"\r", b"\r\n", b"\n\n\n", b"\x1a", b"\xef\xbb\xbf", b"\x1b[2J", b",", b";",
    b'"', b"[", b"]", b"{", b"}", b"\xe2\x80\xae", b"[" * DEEP, b"9" * 5000,
)  # fmt: skip
"""Bytes that end lines, texts and parsers."""
