"""The text of a PDF that Chromium printed: what can be read on its pages, and how wide they are.

Enough of ISO 32000-1 for what Skia writes: plain objects, deflated streams, two-byte codes of glyphs, a ToUnicode map.
"""

import re
import zlib

A4 = {"paperWidth": 8.27, "paperHeight": 11.69}
"""What a printer holds where the page does not ask for more [inch]."""
OBJECT = re.compile(rb"(\d+) 0 obj\n(.*?)endobj", re.S)
SHOWN = re.compile(rb"/F(\d+) [-.\d]+ Tf|<([0-9A-Fa-f]+)>(?=[^\[\]]*(?:Tj|\]))|\b(BT)\b")


def pages_of(data):
    """Return the text of each page, white space left out."""
    objects = {int(number): body for number, body in OBJECT.findall(data)}
    maps = {number: _letters(objects, body) for number, body in objects.items() if b"/ToUnicode" in body}
    pages = [body for body in objects.values() if re.search(rb"/Type\s*/Page\b", body)]
    return [_text(_stream(objects[int(re.search(rb"/Contents (\d+)", body)[1])]), maps) for body in pages]


def sizes_of(data):
    """Return width and height of each page [mm]."""
    boxes = re.findall(rb"/MediaBox \[0 0 ([.\d]+) ([.\d]+)\]", data)
    return [tuple(round(float(side) * 25.4 / 72) for side in box) for box in boxes]


def colours_of(data):
    """Return the colours in which text is written or areas are filled, each as red, green and blue."""
    objects = {int(number): body for number, body in OBJECT.findall(data)}
    pages = [body for body in objects.values() if re.search(rb"/Type\s*/Page\b", body)]
    contents = [_stream(objects[int(re.search(rb"/Contents (\d+)", body)[1])]) for body in pages]
    found = {match for content in contents for match in re.findall(rb"([.\d]+) ([.\d]+) ([.\d]+) rg", content)}
    return {tuple(float(part) for part in colour) for colour in found}


def _stream(body):
    head, _, rest = body.partition(b"stream\n")
    return zlib.decompressobj().decompress(rest) if b"FlateDecode" in head else rest


def _letters(objects, font):
    """Return glyph code → text of a font."""
    table = _stream(objects[int(re.search(rb"/ToUnicode (\d+)", font)[1])])
    found = {}
    for block in re.findall(rb"beginbfchar(.*?)endbfchar", table, re.S):
        for code, text in re.findall(rb"<(\w+)> <(\w+)>", block):
            found[int(code, 16)] = bytes.fromhex(text.decode()).decode("utf-16-be")
    for block in re.findall(rb"beginbfrange(.*?)endbfrange", table, re.S):
        for low, high, text in re.findall(rb"<(\w+)> <(\w+)> <(\w+)>", block):
            first = int(text, 16)
            found |= {code: chr(first + code - int(low, 16)) for code in range(int(low, 16), int(high, 16) + 1)}
    return found


def _text(content, maps):
    letters, said = {}, []
    for font, codes, begins in SHOWN.findall(content):
        if font:
            letters = maps.get(int(font), {})
        elif begins:
            said.append(" ")
        else:
            glyphs = bytes.fromhex(codes.decode())
            said += [letters.get(int.from_bytes(glyphs[k : k + 2]), "") for k in range(0, len(glyphs), 2)]
    return re.sub(r"\s+", "", "".join(said))
