"""The computation of a policy as a graph of ONNX: from an observation and its goals to an action.

It follows ``rher_core::input`` and ``rher_core::goal`` step by step, in single precision like them, so
that both decide the same: in which order the objects are placed, whose turn it is, and what the
network sees. Shapes in comments are those of a batch of B rows, with N objects and S = N + 1 slots of
a goal, of which the first is the gripper's.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from onnx import ModelProto, NodeProto, TensorProto, helper, numpy_helper

from rher._policy_file import Layer, PolicyFile

__all__ = ["OPSET", "model_of"]

#: Version of the operators, which ONNX Runtime has since 1.12 (2022).
OPSET = 17
#: Version of the file's format that came with them.
IR_VERSION = 8

#: As in ``rher_core::input``: normalized numbers, differences and distances are clipped to these.
CLIP, NEAR, FAR = 5.0, 2.0, 3.0
#: As in ``rher_core::learner``.
NORM_EPSILON = 1e-5

#: A number of the observation under an exchange of objects: ``sign * original[from] + offset``.
Images = Sequence[dict[str, Any]]


class Graph:
    """Nodes and constants; a value is known by its name."""

    def __init__(self) -> None:
        self.nodes: list[NodeProto] = []
        self.constants: list[TensorProto] = []

    def constant(self, value: Any, dtype: Any = np.float32) -> str:
        """A constant."""
        name = f"constant{len(self.constants)}"
        array: NDArray[Any] = np.asarray(value, dtype=dtype)
        self.constants.append(numpy_helper.from_array(array, name))
        return name

    def op(self, kind: str, *inputs: str, **attributes: Any) -> str:
        """The output of an operator."""
        output = f"{kind}{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [output], **attributes))
        return output

    def indices(self, value: Any) -> str:
        """A constant of whole numbers."""
        return self.constant(value, np.int64)

    def shaped(self, value: str, *shape: int) -> str:
        """The same numbers in another shape, with as many rows; 0 keeps a dimension."""
        return self.op("Reshape", value, self.indices([0, *shape]))

    def joined(self, *values: str, axis: int = 1) -> str:
        """Values side by side."""
        return self.op("Concat", *values, axis=axis) if len(values) > 1 else values[0]

    def part(self, value: str, begin: int, end: int, axis: int = 1) -> str:
        """A part of a value along an axis."""
        return self.op("Slice", value, *map(self.indices, ([begin], [end], [axis])))

    def clipped(self, value: str, limit: float) -> str:
        """Numbers within ± ``limit``."""
        return self.op("Clip", value, self.constant(-limit), self.constant(limit))

    def dot(self, one: str, other: str) -> str:
        """The product of vectors along the last axis, which has length 3 before and 1 after."""
        products = self.op("Mul", one, other)
        x, y, z = (self.part(products, axis, axis + 1, axis=-1) for axis in range(3))
        return self.op("Add", self.op("Add", x, y), z)

    def length(self, vectors: str) -> str:
        """The lengths of vectors along the last axis, which has length 3 before and 1 after."""
        return self.op("Sqrt", self.dot(vectors, vectors))

    def normalized(self, value: str, statistics: Sequence[dict[str, Any]]) -> str:
        """Numbers in units of their standard deviations, clipped."""
        mean, scale = (
            self.constant([part[key] for part in statistics])
            for key in ("mean", "inverse_deviation")
        )
        return self.clipped(self.op("Mul", self.op("Sub", value, mean), scale), CLIP)

    def taken(self, points: str, order: str) -> str:
        """Points ``[B, S, 3]`` in an order ``[B, S]``, which each row has its own of."""
        order = self.op("Unsqueeze", order, self.indices([-1]))
        return self.op("GatherND", points, order, batch_dims=1)

    def exchanged(self, observation: str, exchanges: Sequence[Images], which: str) -> str:
        """Each row of observations under one of several exchanges, ``which`` of them ``[B]``."""

        def chosen(key: str, dtype: Any) -> str:
            table = [[image[key] for image in images] for images in exchanges]
            return self.op("Gather", self.constant(table, dtype), which)

        moved = self.op("GatherElements", observation, chosen("from", np.int64), axis=1)
        signed = self.op("Mul", chosen("sign", np.float32), moved)
        return self.op("Add", signed, chosen("offset", np.float32))


def model_of(policy: PolicyFile, producer: str, metadata: dict[str, str]) -> ModelProto:
    """The graph of a policy."""
    graph = Graph()
    action = _network(graph, _input(graph, policy), policy.layers)
    checked = [name for name in policy.inputs if not _is_ignored(policy, name)]
    action = _unless_finite(graph, action, checked)
    graph.nodes.append(helper.make_node("Identity", [action], ["action"]))

    def value(name: str, width: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, ["batch", width])

    body = helper.make_graph(
        graph.nodes,
        "policy",
        [value(name, width) for name, width in policy.inputs.items()],
        [value("action", policy.action)],
        graph.constants,
    )
    model = helper.make_model(
        body, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION
    )
    model.producer_name, model.producer_version = "rher", producer
    helper.set_model_props(model, metadata)
    return model


def _is_ignored(policy: PolicyFile, name: str) -> bool:
    """Whether an input changes nothing: what is to be reached stays where it is."""
    return policy.is_reach and name.endswith("achieved_goal")


def _places(graph: Graph, policy: PolicyFile, moment: str = "") -> tuple[str, str]:
    """Where the gripper is, ``[B, 1, 3]``, and where the objects are, ``[B, N, 3]``."""
    at = graph.indices(range(policy.gripper, policy.gripper + 3))
    gripper = graph.op("Gather", f"{moment}observation", at, axis=1)
    objects = "desired_goal" if policy.is_reach else f"{moment}achieved_goal"
    return graph.shaped(gripper, 1, 3), graph.shaped(objects, policy.objects, 3)


def _input(graph: Graph, policy: PolicyFile) -> str:
    """What the network sees, ``[B, inputs]``."""
    encoder, last, slots = policy.encoder, policy.last, policy.objects + 1
    observation = "observation"
    gripper, objects = _places(graph, policy)
    targets = graph.shaped("desired_goal", policy.objects, 3)
    if encoder.get("order"):
        orders, exchanges = _orders(policy)
        chosen = _choice(graph, policy, orders, targets)
        relay = graph.op("Gather", graph.indices(orders), chosen)
        observation = graph.exchanged(observation, exchanges, chosen)
        objects, targets = graph.taken(objects, relay), graph.taken(targets, relay)

    # The goal of the whole task: what it is not about stays where it is.
    wanted = graph.part(targets, 0, last + 1)
    if last + 1 < policy.objects:
        wanted = graph.joined(wanted, graph.part(objects, last + 1, policy.objects))
    wanted_gripper = graph.part(objects, last, last + 1) if policy.is_reach else gripper
    blank_slot = last + 1 if policy.is_reach else 0

    places = graph.joined(gripper, objects)
    wanted = graph.joined(wanted_gripper, wanted)
    order: str | None = None
    if (turns := encoder.get("turns")) and last > 0:
        first = _first(graph, objects, targets, turns["tolerances"][:last])
        observation = graph.exchanged(observation, turns["observations"], first)
        in_turn = [
            [0, *(1 + (turn + place) % policy.objects for place in range(policy.objects))]
            for turn in range(policy.objects)
        ]
        order = graph.op("Gather", graph.indices(in_turn), first)
        places, wanted = graph.taken(places, order), graph.taken(wanted, order)

    def by_slot(values: Any, dtype: Any) -> str:
        """What each slot has, ``[B, S, 1]``; ``[1, S, 1]`` where it is the same in every row."""
        table = np.asarray(values)[:, None]
        if order is None:
            return graph.constant(table[None], dtype)
        return graph.op("Gather", graph.constant(table, dtype), order)

    is_relative = encoder["frame"] == "relative"
    difference = graph.op("Sub", wanted, places)
    position = graph.normalized(difference if is_relative else wanted, encoder["slots"])
    blank = by_slot(np.arange(slots) == blank_slot, np.bool_)
    unused = graph.constant(0.0 if is_relative else -CLIP)
    parts = [
        graph.normalized(observation, [encoder["observation"]]),
        graph.shaped(graph.op("Where", blank, unused, position), 3 * slots),
    ]
    if is_relative:
        rows = graph.op("Shape", "observation", start=0, end=1)
        shape = graph.joined(rows, graph.indices([slots, 1]), axis=0)
        flags = graph.op("Cast", blank, to=TensorProto.FLOAT)
        parts.append(graph.shaped(graph.op("Expand", flags, shape), slots))
    if fine_scale := encoder.get("fine_scale"):
        unit = by_slot(fine_scale["tolerances"], np.float32)
        parts += _fine_scale(graph, policy.objects, places, difference, blank, unit)
    return graph.joined(*parts)


def _fine_scale(
    graph: Graph, objects: int, places: str, difference: str, blank: str, unit: str
) -> list[str]:
    """Distances in units of the tolerance, clipped to what is near."""
    scaled = graph.op("Div", difference, unit)
    length = graph.op("Min", graph.length(scaled), graph.constant(FAR))
    beyond = graph.op("Sub", length, graph.constant(1.0))
    goal = graph.joined(graph.clipped(scaled, NEAR), beyond, axis=2)
    goal = graph.op("Where", blank, graph.constant(0.0), goal)
    parts = [graph.shaped(goal, 4 * (objects + 1))]
    # From the gripper to every object, and from the first object to every later one.
    for origin in range(min(2, objects)):
        rest = (origin + 1, objects + 1)
        place = graph.part(places, origin, origin + 1)
        away = graph.op("Sub", graph.part(places, *rest), place)
        scaled = graph.op("Div", away, graph.part(unit, *rest))
        parts.append(graph.shaped(graph.clipped(scaled, NEAR), 3 * (objects - origin)))
    return parts


def _first(graph: Graph, objects: str, targets: str, tolerances: list[float]) -> str:
    """The object whose turn it is, ``[B]``: the first that is not at its target, or the last."""
    last = len(tolerances)
    away = graph.op("Sub", graph.part(targets, 0, last), graph.part(objects, 0, last))
    distances = graph.shaped(graph.length(away), last)
    placed = graph.op("LessOrEqual", distances, graph.constant(tolerances))
    misplaced = graph.op("Cast", graph.op("Not", placed), to=TensorProto.FLOAT)
    padded = graph.op("Pad", misplaced, graph.indices([0, 0, 0, 1]), graph.constant(1.0))
    return graph.op("ArgMax", padded, axis=1, keepdims=0)


def _orders(policy: PolicyFile) -> tuple[list[list[int]], list[Images]]:
    """The orders that are chosen from, the given one first, and what observations are in each."""
    others = policy.encoder["order"]["others"]
    given = [{"from": at, "sign": 1.0, "offset": 0.0} for at in range(policy.observation)]
    orders = [list(range(policy.objects)), *(other["order"] for other in others)]
    return orders, [given, *(other["observation"] for other in others)]


def _choice(graph: Graph, policy: PolicyFile, orders: list[list[int]], targets: str) -> str:
    """Which of the orders promises most where an episode begins, ``[B]``."""
    model, objects = policy.encoder["order"], policy.objects
    gripper, starts = _places(graph, policy, "first_")
    points = graph.joined(gripper, starts, targets)

    def at(which: list[list[int]]) -> str:
        """Some of the points for each order, ``[B, orders, distances, 3]``."""
        return graph.op("Gather", points, graph.indices(which), axis=1)

    # Distances between two points, and from a line between two points to a third one.
    ways = [_ways(order, objects) for order in orders]
    begin, end = (at([[pair[side] for pair in pairs] for pairs, _ in ways]) for side in range(2))
    start, stop, point = (
        at([[line[part] for line in lines] for _, lines in ways]) for part in range(3)
    )
    between = graph.length(graph.op("Sub", end, begin))
    meters = graph.joined(between, _distance_to_line(graph, start, stop, point), axis=2)
    tolerances = graph.op("Div", meters, graph.constant(model["tolerance"]))
    meters, tolerances = (
        graph.op("Cast", each, to=TensorProto.DOUBLE) for each in (meters, tolerances)
    )
    one = graph.constant(1.0, np.float64)
    squares = graph.op("Mul", tolerances, tolerances)
    nearness = graph.op("Reciprocal", graph.op("Add", squares, one))
    features = graph.joined(meters, nearness, axis=3)
    weights = np.asarray(model["weights"]).reshape(-1, 2)[_order_of_features(objects)]
    weighted = graph.op("Mul", features, graph.constant(weights, np.float64))
    scores = graph.op("ReduceSum", weighted, graph.indices([2, 3]), keepdims=0)
    return graph.op("ArgMax", scores, axis=1, keepdims=0)


def _ways(
    order: list[int], objects: int
) -> tuple[list[tuple[int, int]], list[tuple[int, int, int]]]:
    """Pairs of points whose distance matters in an order, and lines with a point beside them, both
    as places in a list of the gripper, the objects and their targets; as in
    ``rher_core::input::distances``.
    """
    start, target = [1 + it for it in order], [1 + objects + it for it in order]
    pairs, lines, hand = [], [], 0
    for begin, end in zip(start, target, strict=True):
        pairs += [(hand, begin), (begin, end)]
        hand = end
    for this in range(objects):
        for other in range(objects):
            if other != this:
                pairs.append((start[this], target[other]))
                point = start[other] if other > this else target[other]
                lines.append((start[this], target[this], point))
            if other > this:
                pairs += [(start[this], start[other]), (target[this], target[other])]
    return pairs, lines


def _order_of_features(objects: int) -> list[int]:
    """Where the distances of :func:`_ways`, pairs before lines, are in the list of the model."""
    pairs, lines = list(range(2 * objects)), []
    place = 2 * objects
    for this in range(objects):
        for other in range(objects):
            if other != this:
                pairs.append(place)
                lines.append(place + 1)
                place += 2
            if other > this:
                pairs += [place, place + 1]
                place += 2
    return pairs + lines


def _distance_to_line(graph: Graph, start: str, end: str, point: str) -> str:
    """From points to the nearest points of straight lines."""
    line, reach = graph.op("Sub", end, start), graph.op("Sub", point, start)
    squared, zero = graph.dot(line, line), graph.constant(0.0)
    share = graph.op("Div", graph.dot(line, reach), squared)
    share = graph.op("Where", graph.op("Greater", squared, zero), share, zero)
    share = graph.op("Clip", share, zero, graph.constant(1.0))
    return graph.length(graph.op("Sub", reach, graph.op("Mul", line, share)))


def _network(graph: Graph, values: str, layers: list[Layer]) -> str:
    """The actor: rectified layers, and numbers within −1 and 1 at the end.

    In double precision: runtimes sum in orders of their own, and where large terms cancel, that
    would differ from the package's sums by more than these differ from the exact ones.
    """

    def doubled(value: str) -> str:
        return graph.op("Cast", value, to=TensorProto.DOUBLE)

    values = doubled(values)
    for index, layer in enumerate(layers):
        weight, bias = (doubled(graph.constant(each)) for each in (layer.weight, layer.bias))
        values = graph.op("Gemm", values, weight, bias)
        if layer.norm is not None:
            scale, shift = (doubled(graph.constant(each)) for each in layer.norm)
            values = graph.op("LayerNormalization", values, scale, shift, epsilon=NORM_EPSILON)
        values = graph.op("Relu" if index + 1 < len(layers) else "Tanh", values)
    return graph.op("Cast", values, to=TensorProto.FLOAT)


def _unless_finite(graph: Graph, action: str, inputs: list[str]) -> str:
    """The action, or NaN in rows where an input is not finite: they must not be carried out."""
    numbers = graph.op("Abs", graph.joined(*inputs))
    largest = graph.constant(np.finfo(np.float32).max)
    finite = graph.op("Cast", graph.op("LessOrEqual", numbers, largest), to=TensorProto.INT32)
    all_finite = graph.op("ReduceMin", finite, axes=[1], keepdims=1)
    is_fine = graph.op("Cast", all_finite, to=TensorProto.BOOL)
    return graph.op("Where", is_fine, action, graph.constant(np.nan))
