//! Libraries that are not quite Open Image Denoise, built here (`denoiser.c`).

use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds the library into a folder, with macros (`NAME=VALUE`) that say what is wrong with it.
pub fn build(folder: &Path, name: &str, macros: &[&str]) -> PathBuf {
    let (source, library) = (folder.join("denoiser.c"), folder.join(name));
    std::fs::write(&source, include_str!("denoiser.c")).expect("written");
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .args([&library, &source])
        .args(macros.iter().map(|name| format!("-D{name}")))
        .output()
        .expect("a C compiler: install gcc");
    let errors = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{errors}");
    library
}
