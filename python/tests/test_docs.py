"""Every public function and class says how accurate it is, and shows a use of itself that runs."""

from __future__ import annotations

import inspect

import pytest

import ylm
from ylm import zonal

PUBLIC = [(ylm, name) for name in ylm.__all__] + [(zonal, name) for name in zonal.__all__]
ITEMS = [
    (f"{module.__name__}.{name}", getattr(module, name))
    for module, name in PUBLIC
    if callable(getattr(module, name)) and not issubclass(type(getattr(module, name)), type(pytest))
]


@pytest.mark.parametrize("name, item", ITEMS)
def test_public_items_have_documentation_with_an_example(name, item):
    text = inspect.getdoc(item) or ""
    assert len(text.splitlines()[0]) > 10
    if isinstance(item, type) and issubclass(item, Exception):
        return
    assert ">>> " in text, f"{name} shows no example"
    assert "Notes" in text, f"{name} says nothing of its error or source"


MEMBERS = [ylm.AxialProduct, ylm.Baked, *ylm.Baked.__mro__[1:-1], ylm.Brdf, ylm.Field, ylm.Light, ylm.Mesh, ylm.Stage]


@pytest.mark.parametrize("item", [*MEMBERS, ylm.TurnedProduct, ylm.Turn])
def test_public_members_have_documentation(item):
    for name, member in vars(item).items():
        if not name.startswith("_"):
            assert inspect.getdoc(member), f"{item.__name__}.{name} has no documentation"
