"""What a mission's page says of turns: the ratio and its rule, and what planning with turns is worth."""

from __future__ import annotations

from reports.pages.turns import coupled, spaced

BOUND = {"objective": 90.0, "bound": 81.0, "by": "16 sectors", "gap": 0.1}


def test_the_ratio_stands_with_its_rule_and_what_was_done() -> None:
    said = {"ratio": 4.4096, "radius": 120.0, "advice": "turns count", "coupled": False}
    (words,) = spaced(said)
    assert isinstance(words, str)
    assert "4.41: turns count" in words
    assert "below 5 and not above 10" in words
    assert "[flight] coupled plans both" in words
    assert "planned together here" in str(spaced(said | {"coupled": True})[0])
    assert spaced(None) == []


def test_what_coupling_is_worth_is_told_and_that_nothing_can_be_compared() -> None:
    words = coupled({"longest": {"coupled": 90.0, "decoupled": 120.0}, "by": "coupled"}, "memetic", BOUND)
    assert "90.00 s of flight" in words
    assert "take 120.00 s: 25.0% are saved" in words
    assert "10.0% too long" in words
    assert "cannot be flown as they are" in coupled(
        {"longest": {"coupled": 90.0, "decoupled": None}, "by": "coupled"}, "memetic", BOUND
    )
