"""The tables of what is chosen for a case that names no method, from pgimp's own rules."""

from pgimp.case.choices.body_rules import MASS, OF_BODIES, VOLUMETRIC
from pgimp.case.choices.rules import Rule
from pgimp.case.choices.scene_rules import BY_MATERIAL, CONTACT, OF_SCENES


def rules() -> str:
    """All rules, in the order in which they are tried."""
    lines = ["| key | chosen | where | why | figures |", "|---|---|---|---|---|"]
    before = ""
    for rule in (*OF_BODIES, *MASS, *VOLUMETRIC, *OF_SCENES, *BY_MATERIAL, *CONTACT):
        key = f"`{_name(rule)}`" if rule.key != before else ""
        before = rule.key
        value = f"`{str(rule.value).lower()}`"
        lines.append(f"| {key} | {value} | {rule.when} | {rule.reason} | {_figure(rule)} |")
    return "\n".join(lines)


def _name(rule: Rule) -> str:
    return "time.step.courant" if rule.key == "courant" else rule.key


def _figure(rule: Rule) -> str:
    """What supports a rule, with the page where that is measured."""
    name, _, section = rule.page.partition("#")
    link = f"#{section}" if name == "methods.md" and section else rule.page
    return f"{rule.figure} ([page]({link}))"
