"""Writes the tables of this directory: environments of gymnasium and minigrid, state by state, from their own code.

    pip install gymnasium==1.4.0 minigrid==3.2.0
    python make.py

A table has a line for each thing it says:
    from      the environment and the package it is taken from
    sense     a type of observation and its properties, all integers
    actions   the names of the actions, in the environment's order
    goal      the observation in which an episode has succeeded: a sense and its values, or '*:' and another sense with
              its property, which has the value of the present episode
    starts    the states in which an episode begins, all equally probable
    state     what is perceived in the next state, counted from 0: values of the senses, in their order, '-' for none,
              '+' for one without values, ';' between several
    next      of that state: for each action the states that follow, with ' ' between actions; 3*2/3,7*1/3 are chances;
              'end' when the episode is over there
"""

import copy
import itertools
from fractions import Fraction

import gymnasium
import minigrid
from minigrid.core.constants import IDX_TO_OBJECT
from minigrid.core.world_object import Door, Key


def outcome(state, chance):
    chance = Fraction(chance).limit_denominator(1000)
    return str(state) if chance == 1 else f"{state}*{chance}"


def write(name, source, senses, actions, goal, starts, states):
    """`states` has for each state its values, for each sense a tuple, None or a list of tuples, and its transitions, or None
    at the end."""

    def word(value):
        if isinstance(value, list):
            return ";".join(map(word, value)) or "-"
        return "-" if value is None else ",".join(map(str, value)) or "+"

    with open(f"{name}.txt", "w") as out:
        print(f"from {source}", file=out)
        for sense, properties in senses:
            print(' '.join(["sense", sense, *properties]), file=out)
        print(f"actions {' '.join(actions)}", file=out)
        print(f"goal {goal}", file=out)
        print(f"starts {' '.join(map(str, starts))}", file=out)
        for values, following in states:
            print(f"state {' '.join(map(word, values))}", file=out)
            if following is None:
                print("next end", file=out)
                continue
            chances = []
            for outcomes in following:
                chances.append(",".join(outcome(*each) for each in sorted(outcomes.items())))
            print(f"next {' '.join(chances)}", file=out)


def toy_text(name, identity, senses, actions, goal, decode, **settings):
    """An environment that has its whole table. What is never reached from a start is left out."""
    environment = gymnasium.make(identity, **settings).unwrapped
    table = environment.P
    first = [int(s) for s, p in enumerate(environment.initial_state_distrib) if p > 0]
    ends = {following for actions_of in table.values() for outcomes in actions_of.values()
            for _, following, _, over in outcomes if over}
    order, number = list(first), {}
    for state in order:
        if state in number:
            continue
        number[state] = len(number)
        if state not in ends:
            order.extend(int(o[1]) for outcomes in table[state].values() for o in outcomes if o[0] > 0)
    states = []
    for state in number:
        following = None
        if state not in ends:
            following = []
            for action in range(len(actions)):
                outcomes = {}
                for chance, after, _, _ in table[state][action]:
                    if chance > 0:
                        outcomes[number[int(after)]] = outcomes.get(number[int(after)], 0) + chance
                following.append(outcomes)
        states.append((decode(environment, state), following))
    source = f"{identity} of gymnasium {gymnasium.__version__}"
    if settings:
        source += ", " + ", ".join(f"{key}={value}" for key, value in settings.items())
    write(name, source, senses, actions, goal, [number[s] for s in first], states)


def lake(name, size, slippery):
    end = size * size - 1
    toy_text(name, "FrozenLake-v1", [("at", ["place"])], ["left", "down", "right", "up"], f"at {end}",
             lambda _, state: [(state,)], map_name=f"{size}x{size}", is_slippery=slippery)


# Layouts are drawn from so many seeds.
LAYOUTS = 1_000

MOVES = ["left", "right", "forward", "pickup", "drop", "toggle", "done"]


def grid_world(name, identity, seed):
    """A layout of minigrid, of which the whole state is perceived. Doors and keys are what can change."""
    environment = gymnasium.make(identity)
    environment.reset(seed=seed)
    start = environment.unwrapped
    start.max_steps = 10**9
    cells = list(itertools.product(range(start.width), range(start.height)))

    def things(env):
        found = [(kind, x, y, env.grid.get(x, y)) for x, y in cells for kind in (Door, Key)
                 if isinstance(env.grid.get(x, y), kind)]
        door = next(((x, y, 0 if d.is_open else 2 if d.is_locked else 1) for k, x, y, d in found if k is Door), None)
        key = next(((x, y) for k, x, y, d in found if k is Key), None)
        return door, key, env.carrying is not None

    def identity_of(env):
        return tuple(map(int, env.agent_pos)), int(env.agent_dir), things(env)

    def percept(env):
        (x, y), direction, (door, key, carries) = identity_of(env)
        values = [(x, y), (direction,)]
        if door:
            values += [door[2:], key, (1,) if carries else (0,)]
        return values

    number, queue, states = {identity_of(start): 0}, [start], []
    while queue:
        env = queue.pop(0)
        here = env.grid.get(*env.agent_pos)
        if here is not None and here.type == "goal":
            states.append((percept(env), None))
            continue
        following = []
        for action in range(len(MOVES)):
            after = copy.deepcopy(env)
            after.step(action)
            state = identity_of(after)
            if state not in number:
                number[state] = len(number)
                queue.append(after)
            following.append({number[state]: 1})
        states.append((percept(env), following))
    goals = [cell for cell in cells if (t := start.grid.get(*cell)) is not None and t.type == "goal"]
    senses = [("at", ["x", "y"]), ("facing", ["direction"])]
    goal = f"at {goals[0][0]},{goals[0][1]}"
    if things(start)[0]:
        senses += [("door", ["state"]), ("key", ["x", "y"]), ("carries", ["key"])]
    source = f"{identity} of minigrid {minigrid.__version__}, seed {seed}, the whole state"
    write(name, source, senses, MOVES, goal, [0], states)


def seen_world(name, identity):
    """All layouts of minigrid, of which what the agent sees is perceived: things by how far ahead and to which side they are.
    Where it stands when it succeeds is `reached`, which it does not see."""
    environment = gymnasium.make(identity)
    number, queue, starts, states = {}, [], [], []

    def identity_of(env):
        carried = env.carrying and (env.carrying.type, env.carrying.color)
        return env.grid.encode().tobytes(), tuple(map(int, env.agent_pos)), int(env.agent_dir), carried

    def enter(env):
        state = identity_of(env)
        if state not in number:
            number[state] = len(number)
            queue.append(copy.deepcopy(env))
        return number[state]

    def percept(env, is_over):
        seen = {"wall": [], "goal": [], "key": [], "door": []}
        view = env.gen_obs()["image"]
        width, height, _ = view.shape
        for column, row in itertools.product(range(width), range(height)):
            kind, _, status = map(int, view[column, row])
            where = height - 1 - row, column - width // 2
            if where != (0, 0) and IDX_TO_OBJECT[kind] in seen:
                told = (status, *where) if IDX_TO_OBJECT[kind] == "door" else where
                seen[IDX_TO_OBJECT[kind]].append(told)
        values = [(int(env.agent_dir),), *seen.values(), () if env.carrying else None]
        return [*values, () if is_over else None]

    for seed in range(LAYOUTS):
        environment.reset(seed=seed)
        environment.unwrapped.max_steps = 10**9
        start = enter(environment.unwrapped)
        if start not in starts:
            starts.append(start)
    while queue:
        env = queue.pop(0)
        here = env.grid.get(*env.agent_pos)
        if here is not None and here.type == "goal":
            states.append((percept(env, True), None))
            continue
        following = []
        for action in range(len(MOVES)):
            after = copy.deepcopy(env)
            after.step(action)
            following.append({enter(after): 1})
        states.append((percept(env, False), following))
    place = ["ahead", "side"]
    senses = [("facing", ["direction"]), ("wall", place), ("goal", place), ("key", place), ("door", ["state", *place])]
    senses += [("carries", []), ("reached", [])]
    kept = [at for at, (sense, _) in enumerate(senses) if any(values[at] not in (None, []) for values, _ in states)]
    states = [([values[at] for at in kept], following) for values, following in states]
    source = f"{identity} of minigrid {minigrid.__version__}, what the agent sees"
    write(name, source, [senses[at] for at in kept], MOVES, "reached +", starts, states)


if __name__ == "__main__":
    for size in (4, 8):
        lake(f"lake-{size}", size, False)
        lake(f"lake-{size}-slippery", size, True)
    toy_text("cliff", "CliffWalking-v1", [("at", ["place"])], ["up", "right", "down", "left"], "at 47",
             lambda _, state: [(state,)])
    toy_text("taxi", "Taxi-v4", [("row", ["number"]), ("column", ["number"]), ("passenger", ["at"]), ("destination", ["at"])],
             ["south", "north", "east", "west", "pickup", "dropoff"], "passenger *:destination.at",
             lambda environment, state: [(v,) for v in map(int, environment.decode(state))])
    grid_world("empty-8", "MiniGrid-Empty-8x8-v0", 1)
    grid_world("door-key-5", "MiniGrid-DoorKey-5x5-v0", 1)
    seen_world("empty-5-seen", "MiniGrid-Empty-5x5-v0")
    seen_world("door-key-5-seen", "MiniGrid-DoorKey-5x5-v0")
