"""Values of Python as a job file writes them."""
import json
import os
import re
from collections.abc import Mapping

from ._errors import UsageError


def path_bytes(path):
    """The bytes of a path; refused where one of them is zero: the system takes the bytes before it for the name."""
    name = os.fsencode(path)
    if b"\0" in name:
        raise UsageError(f"a path has no zero bytes; found {name!a}, expected the name of a file",
                         problem="a path has no zero bytes", found=ascii(name), expected="the name of a file")
    return name


def flag(name, value):
    """True or False, of Python or numpy, also as a number; refused where it is something else."""
    if value is None or isinstance(value, int) or type(value).__name__ in ("bool", "bool_"):
        return bool(value)
    raise UsageError(f"{name} is no flag; found {value!r}, expected True or False", problem="no flag", place=name,
                     found=repr(value), expected="True or False")


def unicode_text(place, text):
    """The text; refused where it is no Unicode, which job files (TOML) are."""
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise UsageError(f"{place} is no Unicode; found {text!a}. Files of such a name are named by a pattern, \"*.ply\"",
                         problem="a text is no Unicode", place=place, found=ascii(text), expected="a text of Unicode",
                         advice="Files of such a name are named by a pattern, \"*.ply\"") from None
    return text


def _quoted(key, text):
    return json.dumps(unicode_text(key, text), ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(key, name):
    """The name of a value in a table; quoted where it has to be."""
    return name if re.fullmatch("[A-Za-z0-9_-]+", name) else _quoted(key, name)


def written(key, value):
    """The value as TOML."""
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if hasattr(value, "tolist"):  # an array of numpy, or a flag or number
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _quoted(key, value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key, str(name))} = {written(key, item)}" for name, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(written(key, item) for item in value) + "]"
    for type_ in (int, float):  # of a subclass, such as that of an enumeration, the number alone
        if isinstance(value, type_):
            return type_.__repr__(value)
    found = type(value).__name__
    expected = "a flag, a number, a text, a path, or a list or dictionary of these"
    raise UsageError(f"{key} has a value of an unsuitable type; found {found}, expected {expected}",
                     problem="a value of an unsuitable type", place=key, found=found, expected=expected)


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
