"""What can be asked of a learner, whether it is a daemon's, on disk, or in this process.

Answers are dicts, with the fields that ``pschema --json`` prints; ``docs/CLI.md`` links to the JSON Schema of each.
"""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Callable, Optional

from . import _checked, _native

if TYPE_CHECKING:
    import networkx
    import pandas

__all__ = ["Answer", "Explanation", "Graph", "Questions"]

#: An answer, field by field.
Answer = dict[str, Any]

#: How many schemas are asked for at a time.
_PAGE = 100
#: The orders in which schemas are listed.
_SORTS = ("age", "uses", "probability", "excitation")
#: The largest number of a step.
_STEP_MAX = 2**64 - 1


def _given(check: Callable[..., Any], place: str, given: Any, *more: Any) -> Any:
    """An argument that may be left out, checked if it is not."""
    return None if given is None else check(place, given, *more)


class Explanation(Answer):
    """Why an action was chosen. A notebook shows it in the words of ``pschema explain``, and so does ``print``."""

    def __str__(self) -> str:
        return _native.explanation(json.dumps(self).encode())

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


class Graph(Answer):
    """The network of schemas. A notebook shows it as the picture of ``pschema graph``; `svg` is its text."""

    @property
    def svg(self) -> str:
        """The picture, as SVG."""
        return _native.graph_svg(json.dumps(self).encode())

    def _repr_svg_(self) -> str:
        return self.svg


class Questions:
    """The questions. Each raises a `pschema.AnswerError` where the learner has no answer, with the reason, and a `pschema.ArgumentError`
    where it is given what it does not take."""

    def _asked(self, kind: str, question: dict[str, Any]) -> Any:
        raise NotImplementedError

    def status(self) -> Answer:
        """How the learner is: step, stage, schemas, bodies, latencies in µs."""
        return self._answer("status", {})

    def _answer(self, kind: str, question: dict[str, Any]) -> Answer:
        answer: Answer = self._asked(kind, question)
        return answer

    def schemas(
        self,
        *,
        action: Optional[str] = None,
        pre: Optional[str] = None,
        post: Optional[str] = None,
        generalised: bool = False,
        sort: str = "age",
        limit: Optional[int] = None,
    ) -> Iterator[Answer]:
        """The schemas, one after another; they are asked for page by page.

        Args:
            action: only those with this action, by its name.
            pre: only those with a pre-condition that this pattern matches: ``"object{colour=blue}"``.
            post: the same of a post-condition.
            generalised: only generalised ones.
            sort: ``age``, ``uses``, ``probability`` or ``excitation``.
            limit: at most so many.
        """
        question: dict[str, Any] = {"generalised": bool(generalised), "sort": _checked.choice("sort", sort, _SORTS)}
        for name, pattern in (("action", action), ("pre", pre), ("post", post)):
            question[name] = _given(_checked.text, name, pattern)
        limit = _given(_checked.whole, "limit", limit)
        return self._listed(question, limit)

    def _listed(self, question: dict[str, Any], limit: Optional[int]) -> Iterator[Answer]:
        told = 0
        while limit is None or told < limit:
            page = _PAGE if limit is None else min(_PAGE, limit - told)
            listed = self._asked("schemas", {**question, "limit": page, "offset": told})["schemas"]
            yield from listed
            told += len(listed)
            if len(listed) < page:
                return

    def schemas_frame(self, **filters: Any) -> pandas.DataFrame:
        """The same as a pandas ``DataFrame``, a row for each schema, with its number as the index; pandas has to be installed."""
        import pandas

        frame = pandas.DataFrame(list(self.schemas(**filters)))
        return frame.set_index("id") if "id" in frame else frame

    def show(self, schema: int) -> Answer:
        """One schema whole: statistics for each observation, examples, counter-examples, lineage."""
        return self._answer("show", {"id": _checked.whole("schema", schema)})

    def claims(self, action: Optional[str] = None, *, limit: int = 0) -> Answer:
        """Under the profile ``full``: what the learner holds to be so of an action, or of each.

        ``trials``, ``trials_with`` and ``trials_without`` count experiences: actions that were carried out. Of what is to be
        expected whatever is done the end of an episode counts as well, of which the type ``episode_ended`` tells. Where ``each`` is true
        every observation of the type counts.
        """
        question = {"action": _given(_checked.text, "action", action), "limit": _checked.whole("limit", limit)}
        return self._answer("claims", question)

    def explain(self, step: Optional[int] = None, *, candidates: int = 5) -> Explanation:
        """Why the action of a step was chosen, term by term; of the last decision if no step is named."""
        asked = _given(_checked.whole, "step", step, 0, _STEP_MAX)
        return Explanation(self._answer("explain", {"step": asked, "candidates_max": _checked.whole("candidates", candidates)}))

    def why_not(self, schema: int, step: Optional[int] = None) -> Answer:
        """What stood in the way of a schema."""
        asked = _given(_checked.whole, "step", step, 0, _STEP_MAX)
        return self._answer("why-not", {"schema": _checked.whole("schema", schema), "step": asked})

    def predict(self, action: str) -> Answer:
        """What an action, as it prints (``"move(reach=0.4)"``), would do in the world as it is; nothing is done."""
        return self._answer("predict", {"action": _checked.text("action", action)})

    def plan(self, *goal: str, again: bool = False, most: Optional[str] = None) -> Answer:
        """How a goal could be brought about from here, as `pschema.Client.achieve` takes one; nothing is done."""
        return self._answer("plan", _checked.wanted(goal, again, most))

    def pursuit(self) -> Answer:
        """How the goal is doing that is pursued, or was the last to be: ``state``, ``achieved``, ``actions``, ``plans``."""
        return self._answer("pursuit", {})

    def report(self) -> Answer:
        """What the curriculum has done so far."""
        return self._answer("report", {})

    def graph(self, *, around: Optional[int] = None, depth: int = 0, goal: Optional[Sequence[str]] = None, limit: int = 0) -> Graph:
        """The network of schemas: all of it, what is tied to one within ``depth`` ties, or the chain to a goal."""
        if isinstance(goal, str):
            goal = [goal]
        question = {
            "around": _given(_checked.whole, "around", around),
            "depth": _checked.whole("depth", depth),
            "goal": _checked.texts("goal", goal or []),
            "limit": _checked.whole("limit", limit),
        }
        return Graph(self._answer("graph", question))

    def words(self) -> dict[str, list[Answer]]:
        """The words that remind the learner of something, each with the schemas that it is associated with.

        Of each schema there are its number (``schema``), how often the word was heard (``occurrences``) of how often it could have been
        (``trials``), and their ratio (``probability``); the most probable first. A word that came with nothing is not among them.

        Every schema is asked for by itself: of ten thousand it takes seconds.
        """
        known: dict[str, list[Answer]] = {}
        for schema in self.schemas():
            for condition in self.show(schema["id"])["associated"]:
                observed = condition["observation"]
                if observed["type"] == "word" and not condition.get("absent"):
                    told = {"schema": schema["id"], **{name: condition[name] for name in ("occurrences", "trials", "probability")}}
                    known.setdefault(observed["properties"]["text"], []).append(told)
        for associated in known.values():
            associated.sort(key=lambda one: -one["probability"])
        return dict(sorted(known.items()))

    def network(self, **which: Any) -> networkx.MultiDiGraph:
        """The graph of `graph` as a networkx ``MultiDiGraph``; networkx has to be installed.

        A node is a schema (``schema``), or several that stand together (``schema`` is none then, ``members`` how many).
        """
        import networkx

        told = self.graph(**which)
        graph = networkx.MultiDiGraph()
        for number, node in enumerate(told["nodes"]):
            graph.add_node(number, **node)
        for edge in told["edges"]:
            graph.add_edge(edge["from"], edge["to"], kind=edge["kind"], count=edge["count"])
        return graph
