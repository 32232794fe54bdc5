"""Games of PettingZoo, whose players are bodies of one learner."""

from __future__ import annotations

import threading
from typing import Any, Optional

from gymnasium import spaces

from . import _native

__all__ = ["Game", "RefusedByRules", "Seat"]


class Game:
    """A game of PettingZoo, whose players take turns; each is the environment of one body, in a thread of its own."""

    def __init__(self, env: Any, seed: Optional[int], stop: _native.Stop) -> None:
        if not hasattr(env, "agent_iter"):
            from pettingzoo.utils import parallel_to_aec

            env = parallel_to_aec(env)
        self.env = env
        self.stop = stop
        self.turn = threading.Condition()
        env.reset(seed=seed)
        self.seats = [Seat(self, player) for player in env.possible_agents]


class Seat:
    """One player's view of a game: an environment in which the moves of the others happen between two of its own."""

    render_mode = None
    spec = None
    #: It has no episodes but those of the game.
    is_seat = True

    def __init__(self, game: Game, player: Any) -> None:
        self.game = game
        self.player = player
        space = game.env.observation_space(player)
        self.masked = isinstance(space, spaces.Dict) and "action_mask" in space.spaces
        self.observation_space = space["observation"] if self.masked else space
        self.action_space = game.env.action_space(player)
        self.unwrapped = game.env.unwrapped
        self.over = False

    def _turn(self) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Waits until it is this player's turn, and returns what is to be seen then. The lock is held."""
        env = self.game.env
        while not self.game.stop.is_set() and env.agent_selection != self.player:
            # The stop flag is not told of.
            self.game.turn.wait(0.05)
        if env.agent_selection == self.player:
            seen, reward, terminated, truncated, info = env.last()
        else:
            seen, reward, terminated, truncated, info = env.observe(self.player), 0.0, False, False, {}
        self.mask = seen["action_mask"] if self.masked else info.get("action_mask")
        self.over = bool(terminated or truncated)
        return (seen["observation"] if self.masked else seen), reward, terminated, truncated, info

    def reset(self, *, seed: Optional[int] = None) -> tuple[Any, dict[str, Any]]:
        with self.game.turn:
            if self.over and not self.game.stop.is_set():
                # A player whose game is over leaves, and the last one to leave begins the next.
                self.game.env.step(None)
                if not self.game.env.agents:
                    self.game.env.reset()
                self.game.turn.notify_all()
            seen, _, _, _, info = self._turn()
            return seen, info

    def step(self, move: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        with self.game.turn:
            if self.mask is not None and not self.mask[int(move) - int(self.action_space.start)]:
                raise RefusedByRules("the rules of the game do not allow it here")
            self.game.env.step(move)
            self.game.turn.notify_all()
            return self._turn()


class RefusedByRules(Exception):
    """An action that can't be taken where the game stands."""
