//! Disks with faults: a library (`faults.c`), built here and preloaded into a program, that makes calls for the files of
//! one folder fail, or ends the program at one of them. So no test needs a full disk, rights that root does not heed, or
//! a network share.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What happens to the files of a folder.
#[derive(Debug, Clone, Copy)]
pub enum Fault<'a> {
    /// Nothing; the number of calls that change something is written to this file.
    Count(&'a Path),
    /// The call of this number, from 1, kills the program.
    Kill(u64),
    /// There is room for so many bytes.
    Full(u64),
    /// Nothing can be made or changed.
    ReadOnly,
    /// Files cannot be without names, as on most systems but Linux.
    Named,
    /// Nothing can take this name.
    NoRename(&'a str),
    /// Folders cannot be synced.
    NoFolderSync,
    /// The folder is moved there once the first file of it is written.
    Move(&'a Path),
}

/// Has a program meet faults in `folder`.
pub fn with_faults<'c>(
    command: &'c mut Command,
    folder: &Path,
    faults: &[Fault<'_>],
) -> &'c mut Command {
    let folder = folder.canonicalize().expect("a folder");
    command
        .env("LD_PRELOAD", library())
        .env("FAULT_FOLDER", folder);
    for fault in faults {
        match fault {
            Fault::Count(file) => command.env("FAULT_COUNT", file),
            Fault::Kill(call) => command.env("FAULT_KILL", call.to_string()),
            Fault::Full(bytes) => command.env("FAULT_FULL", bytes.to_string()),
            Fault::ReadOnly => command.env("FAULT_READ_ONLY", "1"),
            Fault::Named => command.env("FAULT_NAMED", "1"),
            Fault::NoRename(name) => command.env("FAULT_NO_RENAME", name),
            Fault::NoFolderSync => command.env("FAULT_NO_FOLDER_SYNC", "1"),
            Fault::Move(to) => command.env("FAULT_MOVE", to),
        };
    }
    command
}

/// The library, made once.
fn library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("towel-faults-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let (source, library) = (folder.join("faults.c"), folder.join("faults.so"));
        std::fs::write(&source, include_str!("faults.c")).expect("written");
        let built = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([&library, &source])
            .arg("-ldl")
            .output()
            .expect("a C compiler: install gcc");
        let errors = String::from_utf8_lossy(&built.stderr);
        assert!(built.status.success(), "{errors}");
        library
    })
}
