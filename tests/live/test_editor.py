"""The command of the editor is split once, and its values never meet a shell."""

import pytest

from rtcli.live.editor import editor_command, open_editor


def test_placeholders_are_replaced(tmp_path):
    path = tmp_path / "a b; $(touch x).yaml"
    assert editor_command("code -g '{file}:{line}:{column}' --wait", str(path), 12, 5) == [
        "code",
        "-g",
        f"{path}:12:5",
        "--wait",
    ]


def test_placeholder_in_the_name_of_the_file_stays(tmp_path):
    path = tmp_path / "{line}.yaml"
    assert editor_command("vi {file}", str(path), 12, 5) == ["vi", str(path)]


@pytest.mark.parametrize("template", ["", "code 'unfinished"])
def test_command_that_no_shell_could_split_is_refused(template):
    with pytest.raises(ValueError, match=r"empty|quotation"):
        editor_command(template, "scene.yaml", 1, 1)


def test_missing_editor_is_an_error():
    with pytest.raises(FileNotFoundError):
        open_editor(["no-such-editor-of-any-kind"])
