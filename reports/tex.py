"""TeX: text as pdfLaTeX sets it, whatever characters it holds."""

from __future__ import annotations

import unicodedata

LAST_LATIN = "\u017f"
"""The last letter that the font encoding T1 has."""
_SIGNS = {"\\": r"\textbackslash{}", "–": "--", "—": "---", "−": "$-$", "∞": r"$\infty$", "<": "$<$", ">": "$>$"}
_SIGNS |= {"†": r"\textdagger{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "\u00a0": "~", "…": r"\dots{}"}
_SIGNS |= {"≤": r"$\leq$", "≥": r"$\geq$", "×": r"$\times$", "·": r"$\cdot$", "±": r"$\pm$", "½": r"$\frac12$"}
_SIGNS |= {"′": "$'$", "≈": r"$\approx$", "√": r"$\surd$", "Σ": r"$\Sigma$", "θ": r"$\theta$", "σ": r"$\sigma$"}
_SIGNS |= {"’": "'", "‘": "`", "“": "``", "”": "''", "²": "$^2$", "³": "$^3$", "λ": r"$\lambda$", "°": r"$^\circ$"}
_SIGNS |= {character: f"\\{character}" for character in "&%$#_{}"}
_SIGNS |= {character: f"{{{character}}}" for character in "[]*"}  # else the \\ before would take them


def tex(text: str) -> str:
    """Return `text` as LaTeX, its own signs escaped; a character that it cannot set is named by its code."""
    return "".join(_SIGNS.get(sign) or _letter(sign) for sign in text)


def _letter(sign: str) -> str:
    if sign.isascii() or (sign <= LAST_LATIN and unicodedata.category(sign).startswith("L")):
        return sign if sign.isprintable() else " "
    return rf"\texttt{{U+{ord(sign):04X}}}"
