"""The reason for a pixel's value in one sentence: why it is bright, dark, black or background."""

from __future__ import annotations

from collections.abc import Sequence

from rtcli.explain.drawing import brightest
from rtcli.explain.records import (
    BACKGROUND,
    LIT,
    OTHER_SIDE,
    SHINING,
    TURNED_AWAY,
    LightShare,
    Places,
    Sample,
    Story,
)
from rtcli.explain.words import listed
from rtcli.scene.diagnostics.problems import counted

# The most reasons in a sentence.
_MOST_REASONS = 3

# The luma (ITU-R BT.601) of 8-bit values up to which a pixel is dark, and from which on it is bright.
_DARK_LUMA, _BRIGHT_LUMA = 64, 192

# The words for a pixel that has little light or none.
BLACK, DARK = "black", "dark"

# A surface is dark if it reflects less than this of any color.
_DARK_ALBEDO = 0.1

# A light whose cos(theta) is below this grazes the surface.
_GRAZING = 0.2


def sentence_of(story: Story, samples: Sequence[Sample], value: tuple[int, int, int]) -> str:
    """Return the reason for a pixel's value: "black: `tall box` stands between it and lights[0]".

    Parameters
    ----------
    story
        The story of one sample, whose reason is given.
    samples
        All samples of the pixel.
    value
        The pixel's red, green and blue, 0..255.
    """
    look, reason = _look_and_reason(story, value)
    return f"{look}: {reason}{_others(story, samples)}"


def _look_and_reason(story: Story, value: tuple[int, int, int]) -> tuple[str, str]:
    if story.hit.kind == BACKGROUND:
        outcome = story.intersections.outcome  # which counts all objects, though few may be listed
        return BACKGROUND, outcome[0].lower() + outcome[1:].removesuffix(".")
    seen = story.hit.object.label if story.hit.object else ""
    if story.hit.kind == SHINING:
        return _look(value), f"the eye sees {seen}, which carries a light"
    lights = story.lights.lights
    if not lights:
        return _unlit(story, value, _why_no_light(story))
    order = [lights[i] for i in brightest(lights)]
    lit = [share for share in order if share.verdict == LIT]
    if not lit:
        return _unlit(story, value, _why_unlit(order))
    look, reason = _lit(order, lit, value)
    return look, f"{reason}{_surface(story) if look in (BLACK, DARK) else ''}"


def _look(value: tuple[int, int, int]) -> str:
    """Return a word for the brightness of a value."""
    red, green, blue = value
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    return BLACK if luma == 0 else DARK if luma <= _DARK_LUMA else "bright" if luma >= _BRIGHT_LUMA else "lit"


def _unlit(story: Story, value: tuple[int, int, int], reason: str) -> tuple[str, str]:
    """Return the look of a point that no light reaches, and the reason."""
    if any(x > 0 for x in _radiance(story)):
        return f"{_look(value)}, by ambient light only", reason
    return DARK if any(value) else BLACK, reason


def _radiance(story: Story) -> tuple[float, ...]:
    value = story.radiance.numbers[-1].value
    return value if isinstance(value, tuple) else (value,)


def _why_no_light(story: Story) -> str:
    if "max_depth" in story.lights.outcome:
        return "max_depth is 0, so only objects that carry a light are seen"
    return "there are no lights"


def _why_unlit(shares: Sequence[LightShare]) -> str:
    """Return why some lights do not reach the point, the strongest first; those with the same reason together."""
    labels: dict[str, list[str]] = {}
    for share in shares:
        labels.setdefault(_reason(share), []).append(share.label)
    reasons = [
        reason.format(listed(those), are="is" if len(those) == 1 else "are") for reason, those in labels.items()
    ]
    more = len(reasons) - _MOST_REASONS
    return "; ".join(
        [*reasons[:_MOST_REASONS], *([f"{counted(more, 'more reason')} for others"] if more > 0 else [])]
    )


def _reason(share: LightShare) -> str:
    """Return the reason why a light does not reach the point, a format for the labels of lights."""
    if share.verdict == TURNED_AWAY:
        return "the surface faces away from {}"
    if share.verdict == OTHER_SIDE:
        return "{} {are} on the other side of the surface"
    blockers = share.blockers if share.places is None else share.places.hidden
    names = list(dict.fromkeys(item.object.label for item in blockers))
    between = listed(names).replace("{", "{{").replace("}", "}}")
    return f"{between} {'stands' if len(names) == 1 else 'stand'} between it and {{}}"


def _lit(order: Sequence[LightShare], lit: Sequence[LightShare], value: tuple[int, int, int]) -> tuple[str, str]:
    """Return the look of a point that some lights reach, and the reason: what takes the most light away."""
    first, unlit = order[0], [share for share in order if share.verdict != LIT]
    reached = f"{listed([share.label for share in lit])} {'reaches' if len(lit) == 1 else 'reach'} it"
    if first.verdict != LIT:
        return _look(value), f"{_why_unlit(unlit)}; {reached}"
    places = first.places
    if places is not None and places.reaching < places.count:
        return f"{_look(value)}, in part shadow", _in_part(first, places)
    return _look(value), f"{reached}{_how(first)}" + (f"; {_why_unlit(unlit)}" if unlit else "")


def _in_part(share: LightShare, places: Places) -> str:
    reason = f"{places.reaching:,} of {places.count:,} places of {share.label} reach it"
    if places.hidden:
        names = [item.object.label for item in places.hidden]
        return f"{listed(names)} {'hides' if len(names) == 1 else 'hide'} part of {share.label}: {reason}"
    return f"part of {share.label} is below the horizon of the surface: {reason}"


def _how(share: LightShare) -> str:
    """Return how a light reaches a surface that it grazes."""
    cosine = next(item.value for item in share.numbers if item.name == "cos_theta")
    if isinstance(cosine, float) and cosine < _GRAZING:
        return f" at a grazing angle, cos(theta) = {cosine:.2g}"
    return ""


def _surface(story: Story) -> str:
    """Return that the surface reflects little, if it does."""
    albedo = next(item.value for item in story.hit.numbers if item.name == "rho")
    most = max(albedo) if isinstance(albedo, tuple) else albedo
    if most == 0:
        return ", but the surface reflects no light"
    return f", but the surface reflects at most {100 * most:.2g} %" if most < _DARK_ALBEDO else ""


def _others(story: Story, samples: Sequence[Sample]) -> str:
    """Return a note on the samples that see something else."""
    seen = samples[story.sample - 1].object
    others = [sample for sample in samples if sample.object != seen]
    if not others:
        return ""
    verb = "sees" if len(others) == 1 else "see"
    return f" ({len(others):,} of its {len(samples):,} samples {verb} something else)"
