"""The simulated arm as an environment of Gymnasium, with or without a learner of pschema.

    >>> import gymnasium, pschema.gym
    >>> env = gymnasium.make("pschema/Table-v0")

``gymnasium.make("pschema.gym:pschema/Table-v0")`` needs no other import.

An arm with a finger stands at a table with blocks, under a camera. It is the world of ``pschema sim``, with its physics, its camera and its
touch, in this process.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Optional, Union

import gymnasium
import numpy
from gymnasium import spaces

from . import _native
from .declare import Description

__all__ = ["Table"]

#: How many draws a place for a block may take: one that is refused has another block in the way.
_DRAWS_MAX = 1000


class Table(gymnasium.Env[dict[str, Any], Any]):
    """An arm that touches blocks.

    **Observations** are a ``Dict`` of what the arm senses after an action. ``F`` is the number of visual fields, in which the camera's
    picture is laid out; a number of a field says where something is seen, and ``F`` says that it is not in sight.

    | key | space | what it says |
    |---|---|---|
    | ``finger`` | ``Discrete(F + 1)`` | the field that the finger is seen in |
    | ``objects`` | ``MultiDiscrete([F + 1, …])`` | for each of `colours`, the field that a block of it is seen in; the lowest of several |
    | ``touch`` | ``Discrete(2)`` | 1 if the finger is in contact with a block |
    | ``contact`` | ``MultiBinary(4)`` | the sides of the finger that feel it: left, right, near, far |

    **Actions** are ``Discrete(A)``: the postures that the arm was taught, one for each field that its finger reaches, and after them the
    pushes that the world has. `meanings` says what each is, in joint positions from 0 to 1. The finger is lifted over what stands on
    the table, comes down before its goal and goes up to it; a contact ends the move.

    **Reward** is 1 for an action that ends in contact with a block, which ends the episode (terminated), else 0. ``make`` cuts an
    episode off after 20 actions. In each episode blocks stand at places that are drawn anew, all of them within reach.

    ``info`` has ``outcome`` (``"done"``, ``"refused"``, …), its ``reason``, and ``sensed``: the same observations as the body of
    ``pschema sim`` reports them.

    Equal seeds and equal actions are equal episodes, bit for bit and on every machine.

    Args:
        world: ``"wide"`` (224 postures), ``"narrow"`` (112), ``"block-and-ball"``, or the path of a world file.
        blocks: how many of the world's objects stand on the table, the first ones; or their names.
        reward: ``"touch"``; with ``"none"`` there is no reward, and nothing ends an episode.
        render_mode: ``"rgb_array"`` is what the camera sees, height × width × 3 of ``uint8``.

    Raises:
        ValueError: a world that can't be read, a block that is not in it, or more blocks than it has.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 4}  # noqa: RUF012

    def __init__(
        self,
        world: str = "wide",
        blocks: Union[int, Sequence[str]] = 1,
        reward: str = "touch",
        render_mode: Optional[str] = None,
    ) -> None:
        if reward not in ("touch", "none"):
            raise ValueError(f'reward={reward!r}: give "touch" or "none"')
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f'render_mode={render_mode!r}: give "rgb_array", or nothing')
        self.world = world
        self.render_mode = render_mode
        self._rewarded = reward == "touch"
        self._arm = _native.Arm(world, 0)
        #: What the arm declares as a body.
        self.description = Description._of(self._arm.describe())
        senses = {sense.name: sense.properties for sense in self.description.senses}
        #: How many visual fields there are: the number that stands for "not in sight".
        self.fields: int = senses["finger"]["field"].of_kind[1] + 1
        #: The colours of objects, in the order of ``objects``.
        self.colours: tuple[str, ...] = tuple(senses["object"]["colour"].of_kind[0])
        #: The sides of the finger, in the order of ``contact``.
        self.sides: tuple[str, ...] = tuple(senses["contact"]["side"].of_kind[0])
        #: What each action is.
        self.meanings: tuple[_native.Action, ...] = tuple(self._arm.repertoire())
        #: The objects that the world has.
        place = next(command for command in self.description.scene_commands if command.name == "place")
        self.objects: tuple[str, ...] = tuple(place.parameters["object"].of_kind[0])
        self._blocks = self._chosen(blocks)
        #: The numbers of the places within reach, and the field that a block is seen in at each.
        self.places: dict[int, int] = {number: field for number, (field, within) in enumerate(self._arm.places()) if within}
        self.observation_space = spaces.Dict(
            {
                "finger": spaces.Discrete(self.fields + 1),
                "objects": spaces.MultiDiscrete([self.fields + 1] * len(self.colours)),
                "touch": spaces.Discrete(2),
                "contact": spaces.MultiBinary(len(self.sides)),
            }
        )
        self.action_space = spaces.Discrete(len(self.meanings))
        #: What is sensed now, as a body reports it.
        self.sensed: list[tuple[str, tuple[Any, ...]]] = []

    def _chosen(self, blocks: Union[int, Sequence[str]]) -> list[int]:
        if isinstance(blocks, int):
            if not 0 <= blocks <= len(self.objects):
                raise ValueError(f"blocks={blocks}: {self.world} has {len(self.objects)}: {', '.join(self.objects)}")
            return list(range(blocks))
        for name in blocks:
            if name not in self.objects:
                raise ValueError(f"there is no object {name!r} in {self.world}, there are: {', '.join(self.objects)}")
        return [self.objects.index(name) for name in blocks]

    def reset(self, *, seed: Optional[int] = None, options: Optional[Mapping[str, Any]] = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """The arm at rest, and each block at a place within reach.

        ``options={"places": [40]}`` puts the blocks there instead, in their order: see `places`.
        """
        super().reset(seed=seed)
        if seed is not None:
            # All of it anew, so that what was before is nothing to what comes now.
            self._arm = _native.Arm(self.world, int(self.np_random.integers(2**63)))
        for block in self._blocks:
            self._arm.remove(block)
        self._arm.park()
        wanted = (options or {}).get("places")
        if wanted is not None and len(wanted) != len(self._blocks):
            raise ValueError(f"places={wanted!r}: {len(self._blocks)} are wanted, one for each block")
        for number, block in enumerate(self._blocks):
            self._put(block, None if wanted is None else int(wanted[number]))
        return self._observe(), self._info("done", "")

    def _put(self, block: int, place: Optional[int]) -> None:
        within = list(self.places)
        for _ in range(_DRAWS_MAX):
            at = within[int(self.np_random.integers(len(within)))] if place is None else place
            outcome, reason = self._arm.place(block, at)
            if outcome == "done":
                return
            if place is not None:
                raise ValueError(f"{self.objects[block]} at place {place}: {reason}")
        raise ValueError(f"there is no room for {self.objects[block]}: give fewer blocks")

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Takes a posture, or pushes; ``action`` is a number of `meanings`."""
        number = int(action)
        if not 0 <= number < len(self.meanings):
            raise IndexError(f"there is no action {number}: there are {len(self.meanings)}, from 0")
        outcome, reason = self._arm.act(number)
        seen = self._observe()
        touched = self._rewarded and bool(seen["touch"])
        return seen, float(touched), touched, False, self._info(outcome, reason)

    def _observe(self) -> dict[str, Any]:
        self.sensed = self._arm.sense()
        objects = numpy.full(len(self.colours), self.fields, numpy.int64)
        contact = numpy.zeros(len(self.sides), numpy.int8)
        finger, touch = self.fields, 0
        for name, values in self.sensed:
            if name == "finger":
                finger = values[1]
            elif name == "object":
                colour = self.colours.index(values[0])
                objects[colour] = min(objects[colour], values[1])
            elif name == "touch":
                touch = 1
            elif name == "contact":
                contact[self.sides.index(values[0])] = 1
        return {"finger": numpy.int64(finger), "objects": objects, "touch": numpy.int64(touch), "contact": contact}

    def _info(self, outcome: str, reason: str) -> dict[str, Any]:
        return {"outcome": outcome, "reason": reason, "sensed": self.sensed}

    def render(self) -> Any:
        """What the camera sees."""
        if self.render_mode is None:
            return None
        width, height, pixels = self._arm.picture()
        return numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3)
