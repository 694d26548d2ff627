"""The flags that override a study; each is declared with its key."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from fea.base.shipped import TomlTable
from fea.study.changes import TABLES
from fea.study.material_table import MaterialTable
from fea.study.study import Study
from fea.study.tables import Key, checked, hints_of, keys_of, number_of, own_unit, unit_of, unknown_key
from geometry.errors import require


class Override(NamedTuple):
    """A flag as the declaration of the key that it overrides."""

    table: str
    key: str
    declared: Key

    @property
    def hint(self) -> Any:
        """The type of the key."""
        return hints_of(TABLES[self.table])[self.key]

    @property
    def may_be_false(self) -> bool:
        """Whether False says something other than no value."""
        return bool(self.hint == bool | None)

    @property
    def kind(self) -> Any:
        """The type of the flag's value; a quantity may be text with a unit."""
        return self.declared.kind or (self.hint | str if own_unit(self.key) else self.hint)

    @property
    def help(self) -> str:
        """The line of the flag in the help of a command."""
        comment, (_, unit) = self.declared.comment, unit_of(self.key)
        default = getattr(TABLES[self.table], self.key, None)
        parts = (
            f"{comment[:1].upper()}{comment[1:]}",
            f"; in {unit}, or with its unit" if unit else "",
            f"; default: {default}" if default else "",
        )
        return self.declared.help or f"{''.join(parts)}."

    def value(self, given: Any) -> Any:
        """Return the value of the key; raises `InvalidValue` if it has none such."""
        parse = self.declared.parse
        name = f"{self.table}.{self.key}"
        return parse(given) if parse else checked(name, number_of(name, given, self.key), self.hint)


def overrides() -> dict[str, Override]:
    """Return all flags by their names in Python."""
    return {
        declared.flag: Override(table, key, declared)
        for table, cls in TABLES.items()
        for key, declared in keys_of(cls).items()
        if declared.flag
    }


class Flags:
    """Values of flags by their names; None leaves the study as it is, and False mostly does.

    Values come from the command line or Python: numbers and lists for ``rpm``, text for choices and paths.
    """

    def __init__(self, **values: Any) -> None:
        vars(self).update(values)

    def given(self) -> dict[str, Any]:
        """Return the flags that change a study."""
        flags = overrides()
        return {
            name: value
            for name, value in vars(self).items()
            if value is not None and (value is not False or (name in flags and flags[name].may_be_false))
        }

    def applied(self, study: Study) -> Study:
        """Return the study with flags on top. Raises `InvalidValue`: a broken rule, or an unknown flag."""
        flags, changes = overrides(), dict[str, TomlTable]()
        aliases = {each.declared.alias: each for each in flags.values() if each.declared.alias}
        given = self.given()
        for name, value in given.items():
            flag = flags.get(name) or aliases.get(name)
            if flag is None:
                raise unknown_key("flag", name, flags)
            changes.setdefault(flag.table, {})[flag.key] = flag.value(value)
        if "material" in changes:
            study = replace(study, material=MaterialTable(**changes.pop("material")))
        if "engine" in changes:
            rule = "cannot be used with [forces], which replace an engine"
            remedy = "Leave it out, or remove [forces] from the study."
            require(study.forces is None, "--engine", given["engine"], rule, remedy)
            study = study.with_engine(changes.pop("engine")["preset"])
        if "rod" in changes:
            study = replace(study, rod=study.rod.with_file_keys(changes.pop("rod")))
        tables = {name: replace(getattr(study, name), **values) for name, values in changes.items()}
        changed = replace(study, **tables)
        rule = "cannot be used with [forces], which have no speed"
        still = "rpm" not in given or study.forces is None
        require(still, "--rpm", given.get("rpm"), rule, "Leave it out, or give an [engine].")
        cycle = "fatigue" not in given or changed.analysis.cycle
        require(cycle, "--fatigue", given.get("fatigue"), "has no effect without --cycle", "Add --cycle.")
        changed.require_plausible()
        return changed


NO_FLAGS = Flags()


def python_flags(values: Mapping[str, Any], *, writes: bool = True) -> Flags:
    """Return flags of Python's `run`, or of an analysis that `writes` nothing. Raises `InvalidValue`."""
    flags = {name: each for name, each in overrides().items() if writes or not each.declared.writes}
    for name in values:
        if name not in flags and name not in {each.declared.alias for each in flags.values()}:
            raise unknown_key("flag", name, flags)
    return Flags(**values)
