"""Shell completion: the script of each shell, and what it completes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SHELLS = ("bash", "zsh", "fish")
# What the shells that are installed do with a line that is not finished: print its completions.
COMPLETE = {
    "bash": """
        eval "$(_RTCLI_COMPLETE=bash_source rtcli)"
        COMP_WORDS=({line}) COMP_CWORD={last}
        _rtcli_completion rtcli
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """,
    "fish": """
        _RTCLI_COMPLETE=fish_source rtcli | source
        complete --do-complete "{line}" | string replace --regex '\\t.*' ''
    """,
}


def answered(run, shell, words):
    """Return what rtcli answers the script of a shell for a line of words, the last of them not finished."""
    variables = {"_RTCLI_COMPLETE": f"{shell}_complete", "COMP_WORDS": " ".join(words), "COMP_CWORD": words[-1]}
    if shell != "fish":
        variables["COMP_CWORD"] = str(len(words) - 1)
    result = run(env=variables)
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(
    ("words", "completed"),
    [
        (["rtcli", "re"], ["render"]),
        (["rtcli", "render", "--engine", "ref"], ["reference"]),
        (["rtcli", "render", "--thr"], ["--threads"]),
        (["rtcli", "new", "--from", "cor"], ["cornell", "cornell-falloff"]),
    ],
    ids=lambda value: value[-1],
)
def test_commands_options_and_values_are_completed(run, shell, words, completed):
    answer = answered(run, shell, words)
    assert [word for word in completed if word not in answer] == []
    assert "still-life" not in answer


@pytest.mark.parametrize("shell", SHELLS)
def test_script_is_for_the_shell(run, shell):
    result = run(env={"_RTCLI_COMPLETE": f"{shell}_source"})
    assert result.exit_code == 0
    assert f"_RTCLI_COMPLETE={shell}_complete" in result.stdout
    if not shutil.which(shell):
        pytest.skip(f"{shell} is not installed: THE SYNTAX OF ITS SCRIPT IS NOT CHECKED")
    subprocess.run([shell, "-n"], input=result.stdout, text=True, check=True)


@pytest.mark.skipif(os.name == "nt", reason="the shells of Unix")
@pytest.mark.parametrize("shell", COMPLETE)
def test_shell_completes_a_line(shell):
    if not shutil.which(shell):
        pytest.skip(f"{shell} is not installed: ITS COMPLETION IS NOT RUN")
    words = ["rtcli", "new", "--from", "cor"]
    program = COMPLETE[shell].format(line=" ".join(words), last=len(words) - 1)
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    result = subprocess.run(
        [shell, "-c", program], env={**os.environ, "PATH": path}, capture_output=True, text=True, check=True
    )
    assert result.stdout.split() == ["cornell", "cornell-falloff"]
