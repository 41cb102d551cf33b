"""Values of Python as a job file writes them."""
import json
import os
from collections.abc import Mapping

from ._errors import UsageError


def _items(value):
    """The items of a list, a tuple or an array; None for anything else."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return list(value) if isinstance(value, (list, tuple)) else None


def unicode_text(place, text):
    """The text; refused where it is no Unicode, which job files (TOML) are."""
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise UsageError(f"{place} is no Unicode; found {text!a}. Files of such a name are named by a pattern, \"*.ply\"",
                         problem="a text is no Unicode", place=place, found=ascii(text), expected="a text of Unicode",
                         advice="Files of such a name are named by a pattern, \"*.ply\"") from None
    return text


def written(key, value):
    """The value as TOML."""
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(unicode_text(key, value), ensure_ascii=False).replace("\x7f", "\\u007f")
    items = _items(value)
    if items is not None:
        return "[" + ", ".join(written(key, item) for item in items) + "]"
    if hasattr(value, "item"):  # a number of numpy
        value = value.item()
    if isinstance(value, (bool, int, float)):
        return repr(value).lower()
    found = type(value).__name__
    raise UsageError(f"{key} has a value of an unsuitable type; found {found}", problem="a value of an unsuitable type",
                     place=key, found=found, expected="a flag, a number, a text, a path or a list of these")


def _no_dictionary(place, value, expected):
    found = type(value).__name__
    return UsageError(f"{place}: no dictionary; found {found}, expected {expected}", problem="no dictionary", place=place,
                      found=found, expected=expected)


def pairs(values):
    """(key, TOML) for each value that is not None."""
    if not isinstance(values, Mapping):
        raise _no_dictionary("settings", values, "keys and values, {\"fill.max_edges\": 200}")
    return [(unicode_text("a key", str(key)), written(key, value)) for key, value in values.items() if value is not None]


def pairs_of_sections(sections):
    """The same of {"fill": {"max_edges": 200}}."""
    flat = {}
    for section, keys in sections.items():
        if not isinstance(keys, Mapping):
            raise UsageError(f"{section} is no section; expected a dictionary of keys", problem="no section",
                             place=section, found=type(keys).__name__, expected="a dictionary of keys")
        flat.update({f"{section}.{key}": value for key, value in keys.items()})
    return pairs(flat)
