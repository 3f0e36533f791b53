"""One meaning per name, across the package."""

import ast
from collections import defaultdict
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "rtcli"
# Its classes have the names of the document that specifies it.
REFERENCE = PACKAGE / "tracer" / "reference.py"


def public_classes(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node.name for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]


def test_no_two_public_classes_share_a_name():
    homes = defaultdict(list)
    for path in sorted(PACKAGE.rglob("*.py")):
        if path != REFERENCE:
            for name in public_classes(path):
                homes[name].append(path.relative_to(PACKAGE).as_posix())
    assert len(homes) > 100
    assert {name: modules for name, modules in homes.items() if len(modules) > 1} == {}
