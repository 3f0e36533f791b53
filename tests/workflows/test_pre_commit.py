"""The hook for pre-commit, as pre-commit itself installs and runs it in a repository of scenes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HOOKS = ROOT / ".pre-commit-hooks.yaml"
CONFIG = """\
repos:
  - repo: {repository}
    rev: {commit}
    hooks:
      - id: rtcli-validate
        args: {args}
"""

GOOD = """\
camera: {resolution: [40, 30], fov: 40}
lights: [{position: [2, 3, 0], intensity: 1000}]
objects: [{type: sphere, position: [0, 0, -5], radius: 1, color: tomato}]
"""
# The sphere is behind the camera: a warning.
DOUBTFUL = GOOD.replace("-5", "5")
BAD = GOOD.replace("fov: 40", "fov: 200")


def run(*command, cwd, env):
    """Return the exit code of a program and its output."""
    result = subprocess.run(command, cwd=cwd, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return result.returncode, result.stdout


def pre_commit(*arguments, cwd, env):
    return run(sys.executable, "-m", "pre_commit", *arguments, cwd=cwd, env=env)


def git(*arguments, cwd, env):
    code, output = run("git", *arguments, cwd=cwd, env=env)
    assert code == 0, output
    return output.strip()


def test_hooks_file_is_valid(tmp_path):
    assert pre_commit("validate-manifest", str(HOOKS), cwd=ROOT, env=os.environ) == (0, "")
    broken = tmp_path / "hooks.yaml"
    broken.write_text(HOOKS.read_text(encoding="utf-8").replace("entry:", "enter:"), encoding="utf-8")
    code, report = pre_commit("validate-manifest", str(broken), cwd=ROOT, env=os.environ)
    assert code == 1
    assert "Missing required key: entry" in report


@pytest.fixture(scope="module")
def env(pytestconfig, tmp_path_factory):
    """Return an environment for git and pre-commit that is independent of the user's.

    For the hook, rtcli is compiled as quickly as possible, without optimization, and unchanged parts are cached.
    """
    inherited = {name: value for name, value in os.environ.items() if not name.startswith(("GIT_", "RTCLI_"))}
    people = {f"GIT_{role}_{what}": "rtcli" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}
    return {
        **inherited,
        **people,
        "GIT_CONFIG_GLOBAL": os.devnull,
        "GIT_CONFIG_NOSYSTEM": "1",
        "PRE_COMMIT_HOME": str(tmp_path_factory.mktemp("pre-commit")),
        "PRE_COMMIT_COLOR": "never",
        "CARGO_TARGET_DIR": str(pytestconfig.cache.mkdir("pre-commit-target")),
        "CARGO_INCREMENTAL": "0",
        "CARGO_PROFILE_DEV_DEBUG": "0",
        "MATURIN_PEP517_ARGS": "--profile dev",
    }


@pytest.fixture(scope="module")
def needs_network(env, tmp_path_factory):
    """Skip where pre-commit cannot install the hook: without its programs, or without packages and crates."""
    if not (ROOT / ".git").exists():
        pytest.skip("this is no checkout: the hook for pre-commit is not tested")
    for needed in ("git", "cargo"):
        if not shutil.which(needed):
            pytest.skip(f"{needed} is not installed: the hook for pre-commit is not tested")
    folder = tmp_path_factory.mktemp("network")
    options = ["--quiet", "--retries=1", "--no-cache-dir", "--no-deps"]
    pip = [sys.executable, "-m", "pip", "download", *options, "click"]
    crates = ["cargo", "fetch", "--quiet", "--locked", "--manifest-path", str(ROOT / "tracer" / "Cargo.toml")]
    for fetch in (pip, crates):
        code, output = run(*fetch, cwd=folder, env=env)
        if code:
            pytest.skip(f"packages cannot be fetched: the hook for pre-commit is not tested: {output}")


@pytest.fixture(scope="module")
def hook(env, needs_network, tmp_path_factory):
    """Return a repository with this working tree, committed or not, and its commit."""
    folder = tmp_path_factory.mktemp("rtcli")
    listed = git("ls-files", "-z", "--cached", "--others", "--exclude-standard", cwd=ROOT, env=env)
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():  # a deleted file is listed until the deletion is committed
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    git("init", "--quiet", cwd=folder, env=env)
    git("add", "--all", cwd=folder, env=env)
    git("commit", "--quiet", "--message", "snapshot", cwd=folder, env=env)
    return folder, git("rev-parse", "HEAD", cwd=folder, env=env)


# A description, files by name, the hook's arguments, the exit code of `git commit`, and a part of its output.
COMMITS = {
    "good scenes pass, in all folders named scenes": (
        {"scenes/good.yaml": GOOD, "more/scenes/deep/doubtful.yml": DOUBTFUL},
        "[]",
        0,
        ["check scenes with rtcli", "Passed"],
    ),
    "a bad scene is refused, and its problem shown": (
        {"scenes/good.yaml": GOOD, "scenes/with space.yaml": BAD},
        "[]",
        1,
        [
            "Failed",
            "error[E204]: must be less than 180, got 200\n --> scenes/with space.yaml:1:37\n",
            "1 error in 1 of 2 scenes",
        ],
    ),
    "files that are no scenes are left alone": (
        {"other.yaml": BAD, "scenes.yaml": BAD, "myscenes/a.yaml": BAD, "scenes/notes.md": BAD},
        "[]",
        0,
        ["(no files to check)Skipped"],
    ),
    "arguments of the configuration are passed on": (
        {"scenes/doubtful.json": '{"camera": {"resolution": [4, 3], "fov": 40}}'},
        "[--strict]",
        1,
        ["error[W001]"],
    ),
}


# One test, since each pytest process would install the hook again.
@pytest.mark.integration
def test_commits_of_good_scenes_pass_and_those_of_bad_ones_fail(hook, env, tmp_path):
    repository, snapshot = hook
    for what, (files, args, expected, said) in COMMITS.items():
        folder = tmp_path / what
        config = CONFIG.format(repository=repository.as_posix(), commit=snapshot, args=args)
        for name, content in {**files, ".pre-commit-config.yaml": config}.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(content, encoding="utf-8")
        git("init", "--quiet", cwd=folder, env=env)
        assert pre_commit("install", cwd=folder, env=env)[0] == 0
        git("add", "--all", cwd=folder, env=env)
        code, report = run("git", "commit", "--message", "scenes", cwd=folder, env=env)
        assert code == expected, f"{what}: {report}"
        assert [text for text in said if text not in report] == [], f"{what}: {report}"
