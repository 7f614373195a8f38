"""What the page of a mission says of turns: whether they count, and what planning with them is worth."""

from __future__ import annotations

from typing import Any

from reports.pages.blocks import Block


def spaced(said: dict[str, Any] | None) -> list[Block]:
    """Return the spacing ratio and its advice; nothing where it is not known."""
    if said is None:
        return []
    done = (
        "they are planned together here"
        if said["coupled"]
        else "here headings follow routes; [flight] coupled plans both"
    )
    return [
        f"Spacing ratio ρ = √(area / tasks) / turning radius of {said['radius']:g} m = {said['ratio']:.3g}: "
        f"{said['advice']}. The rule is to couple routes and headings below 5 and not above 10; {done}."
    ]


def coupled(said: dict[str, Any], label: str, bound: dict[str, Any]) -> str:
    """Return what routes and headings planned together take, how far from the best, and what coupling them is worth."""
    longest = said["longest"]
    alone, words = longest.get("decoupled"), "Routes planned without turns cannot be flown as they are."
    if alone is not None and alone > 0:
        saved = 1 - bound["objective"] / alone
        words = f"Routes planned without turns, with the best headings, take {alone:.2f} s: {saved:.1%} are saved."
    return (
        f"Routes and headings by {label}, the {said['by']} plan: longest tour {bound['objective']:.2f} s of flight, "
        f"turns included; none can be below {bound['bound']:.2f} s (by {bound['by']}), whatever its headings, so that "
        f"is at most {bound['gap']:.1%} too long. {words} The tours are flown with exactly these headings."
    )
