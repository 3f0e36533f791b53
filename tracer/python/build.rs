//! Copies the scenes of the gallery to where maturin finds them for the wheel: see `include` in `pyproject.toml`.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let scenes = Path::new("../../scenes");
    println!("cargo:rerun-if-changed={}", scenes.display());
    let target = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("gallery");
    if target.exists() {
        fs::remove_dir_all(&target)?; // scenes that are gone
    }
    fs::create_dir_all(&target)?;
    for scene in fs::read_dir(scenes)? {
        let scene = scene?;
        fs::copy(scene.path(), target.join(scene.file_name()))?;
    }
    Ok(())
}
