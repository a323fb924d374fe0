"""Any text is a scene, or one error on one line."""

from hypothesis import given, settings
from hypothesis import strategies as st
from support.random_scenes import damaged_texts

from fenics_yeast import Scene, SceneError


def read(text: str) -> Scene | None:
    """The scene of a text, or None after a one-line error that names its file."""
    try:
        return Scene.from_toml(text, source="any.toml")
    except SceneError as error:
        message = str(error)
        assert message.startswith("any.toml: ") and len(message.splitlines()) == 1
        assert len(message) < 600
        return None


@given(damaged_texts())
def test_a_damaged_scene_is_a_scene_or_one_error(text: str) -> None:
    scene = read(text)
    if scene is not None:
        assert read(scene.to_toml()) == scene


@given(st.text())
@settings(max_examples=20)
def test_any_text_is_an_error(text: str) -> None:
    assert read(text) is None
