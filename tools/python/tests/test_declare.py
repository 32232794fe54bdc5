"""Declarations, and mistakes in them: each is refused where it is made, with its place."""

from __future__ import annotations

import math
from typing import Any, Callable

import pytest

import pschema
from pschema import action, boolean, event, integer, real, state, symbol


def described(*senses: Any, actions: Any = ()) -> pschema.Description:
    return pschema.Description("body", senses=senses, actions=actions)


@pytest.mark.parametrize(
    ("declare", "told"),
    [
        (lambda: described(state("x", at=integer(9, 0))), "observation type x: property at: its minimum 9 is above its maximum 0"),
        (lambda: described(state("x", at=real(0, math.nan, 1))), "observation type x: property at: its limits 0..=NaN"),
        (lambda: described(state("x", at=real(0, 1, 0))), "its resolution 0 is not above zero"),
        (lambda: described(state("x", at=symbol())), "observation type x: property at: it declares no symbols"),
        (lambda: described(state("x", at=symbol("a", "a"))), 'the name "a" is used twice'),
        (lambda: described(state("x", at=symbol("{"))), "holds '{'"),
        (lambda: described(state("x" * 33)), "has 33 bytes, at most 32 are allowed"),
        (lambda: described(state("x" * 1_000_000)), "at most 32 are allowed"),
        (lambda: described(state("x"), state("x")), 'the name "x" is used twice'),
        (lambda: described(*[state(f"s{n}") for n in range(33)]), "observation types: 33, at most 32 are allowed"),
        (lambda: described(state("x", {f"p{n}": boolean() for n in range(9)})), "x: properties: 9, at most 8 are allowed"),
        (lambda: described("x"), "senses[0]: 'x' is none of them; give state(…), event(…) or value(…)"),
        (lambda: described(action("x")), "senses[0]: ActionType"),
        (lambda: described(actions=[state("x")]), "actions[0]: Sense"),
        (lambda: state("x", at=3), "sense x: property at: 3 says nothing of its values"),  # type: ignore[arg-type]
        (lambda: state("x", {"at": boolean()}, at=boolean()), "sense x: a property is given twice"),
        (lambda: integer(0, 1.5), "integer(0, 1.5): 1.5 is no whole number"),  # type: ignore[arg-type]
        (lambda: integer(0, True), "True is no whole number"),
        (lambda: integer(0, 2**64), "does not fit into 64 bits"),
        (lambda: real(0, "1", 1), "'1' is no number"),  # type: ignore[arg-type]
        (lambda: symbol(["a"]), "['a'] is no text"),  # type: ignore[arg-type]
        (lambda: described(actions=[action("go", by=integer(0, 5000))]), "primitives in the repertoire"),
        (lambda: described(actions=[action("go", by=integer(0, 5), primitives=[(6,)])]), "go): parameter by = 6 is outside 0..=5"),
        (
            lambda: described(actions=[action("go", by=integer(0, 5), primitives=[("a",)])]),
            "go: primitive 0: parameter by: 'a' (str) given",
        ),
        (lambda: described(actions=[action("go", by=integer(0, 5), primitives=[{}])]), "go: primitive 0: {} should have the parameters by"),
        (lambda: described(actions=[action("go", by=integer(0, 5), primitives=[(1, 2)])]), "it has 2 values, and the action 1 parameters"),
        (lambda: pschema.Description(""), "the body's name: it is empty"),
        (lambda: pschema.Description(3), "the body's name: 3 is no text"),  # type: ignore[arg-type]
        (lambda: pschema.Description("x", kind=3), "the body's kind: 3 is no text"),  # type: ignore[arg-type]
        (lambda: pschema.Description("\ud800"), "the body's name: '\\ud800' holds half of a character"),
        (lambda: pschema.Description("x", senses=5), "senses=5: give a list of them"),  # type: ignore[arg-type]
        (lambda: pschema.Description("x", actions=None), "actions=None: give a list of them"),  # type: ignore[arg-type]
        (lambda: state(5), "state(): the name of a sense: 5 is no text"),  # type: ignore[arg-type]
        (lambda: event(None), "event(): the name of a sense: None is no text"),  # type: ignore[arg-type]
        (lambda: action(5), "action(): the name of an action: 5 is no text"),  # type: ignore[arg-type]
        (lambda: state("x", [boolean()]), "sense x: [Values("),  # type: ignore[arg-type]
        (lambda: state("x", own="yes"), "sense x: own='yes': give True or False"),  # type: ignore[arg-type]
        (lambda: action("go", primitives=5), "action go: primitives=5: give a list"),  # type: ignore[arg-type]
        (lambda: integer(0, 9, unit=5), "integer(0, 9): its unit: 5 is no text"),  # type: ignore[arg-type]
        (lambda: symbol("a", unit=5), "symbol(): its unit: 5 is no text"),  # type: ignore[arg-type]
        (lambda: symbol("\udc80"), "symbol(): '\\udc80' holds half of a character"),
        (lambda: real(0, 1, 0.1, unit=5), "real(0, 1, 0.1): its unit: 5 is no text"),  # type: ignore[arg-type]
        (lambda: real(0, [1, 2], 1), "[1, 2] is no number"),  # type: ignore[arg-type]
        (lambda: described(state("x", at=pschema.Values("integer", (0,)))), "the description of body: "),
        (lambda: described(state("word", text=symbol("a"))), "observation type word is the learner's own sense of hearing"),
        (
            lambda: described(state("a", at=integer(0, 9)), event("b", at=real(0, 9, 0.5))),
            "property at of b is a real in bins of 0.5, and the property of that name of a is an integer: give both the same kind",
        ),
        (lambda: described(state("a", at=real(0, 9, 1)), state("b", at=real(0, 9, 2))), "property at of b is a real in bins of 2.0, and"),
    ],
)
def test_a_mistake_is_refused_with_its_place(declare: Callable[[], object], told: str) -> None:
    with pytest.raises(pschema.DeclarationError) as refused:
        declare()
    assert told in str(refused.value)
    assert len(str(refused.value)) < 2_000 or "x" * 100 in str(refused.value)


def test_everything_that_can_be_declared() -> None:
    description = pschema.Description(
        "cart",
        senses=[
            state("place", {"x y": integer(-5, 5, unit="cm")}, own=True),
            event("bump", side=symbol("left", "right"), hard=boolean(), at=real(0, 1, 0.1, unit="m")),
        ],
        actions=[action("go", by=integer(-1, 1)), action("turn", to=real(0, 3, 1), primitives=[(1.5,), {"to": 2}])],
        scene_commands=[action("place", x=integer(0, 3))],
        kind="wheels",
    )
    assert repr(description) == "<Description cart: senses place, bump; actions go, turn>"


def test_a_reason_is_whatever_says_why() -> None:
    assert pschema.Outcome.failed(ValueError("stuck")).reason == "stuck"  # type: ignore[arg-type]
    assert pschema.Outcome.refused("\ud800").reason == "\\ud800"


def test_a_value_is_one_number() -> None:
    score = pschema.value("score", points=integer(-5, 5))
    assert score.value
    assert score.transient
    assert pschema.Description("x", senses=[score, event("bump")]).senses[0] == score
    for wrong, told in (
        (pschema.value("score", won=boolean()), "won is no number"),
        (pschema.value("score"), "one integer or real"),
        (pschema.value("score", a=integer(0, 1), b=integer(0, 1)), "not just one property"),
    ):
        with pytest.raises(pschema.DeclarationError, match=told):
            pschema.Description("x", senses=[wrong])
