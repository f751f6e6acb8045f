"""Models of Gymnasium-Robotics in which one block is several."""

import copy
from pathlib import Path
from xml.etree import ElementTree

__all__ = ["copied"]

#: Bodies of a model: the block, and what its goal is marked in.
BLOCK, MARK = "object0", "target0"


def copied(model: Path, blocks: int, folder: Path) -> Path:
    """Writes a model into a folder that has a block once into another in which it is there several
    times, with as many marks of goals.

    Every block is a copy of the first with a number of its own in its names: ``object1``,
    ``object1:joint``. They lie beside the table, 10 cm from each other.
    """
    tree = ElementTree.parse(model)
    root = tree.getroot()
    for include in root.iter("include"):
        include.set("file", str(model.parent / include.attrib["file"]))
    for compiler in root.iter("compiler"):
        for kind in ("meshdir", "texturedir"):
            compiler.set(kind, str((model.parent / compiler.attrib[kind]).resolve()))
    for what in (BLOCK, MARK):
        parent, first = next(
            (parent, child)
            for parent in root.iter()
            for child in parent
            if child.get("name") == what and child.tag in ("body", "site")
        )
        for number in range(1, blocks):
            other = copy.deepcopy(first)
            for part in other.iter():
                if name := part.get("name"):
                    part.set("name", name.replace(what, f"{what[:-1]}{number}"))
            x, y, z = first.attrib["pos"].split()
            other.set("pos", f"{x} {float(y) + 0.1 * number} {z}")
            parent.append(other)
    path = folder / model.name
    tree.write(path)
    return path
