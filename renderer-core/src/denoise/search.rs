//! Where Open Image Denoise is looked for.
//!
//! Somebody who names a file or a folder means that one: nothing else is tried then. Without, the first place that has a
//! library that can be used wins, and what was wrong with those before it is kept, for who asks why.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{DenoiseError, Denoiser, Library};

/// Names of the library's file on this system, the usual one first.
pub const FILE_NAMES: &[&str] = if cfg!(windows) {
    &["OpenImageDenoise.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"]
} else {
    &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"]
};

/// What the search starts from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Places {
    /// The file to take; empty: none is to be used.
    pub library: Option<OsString>,
    /// A folder that the user has named.
    pub folder: Option<PathBuf>,
    /// Other folders, the best first.
    pub folders: Vec<PathBuf>,
    /// Whether the system is asked by the bare names as well.
    pub system: bool,
}

impl Places {
    /// The environment variable that names the file.
    pub const LIBRARY: &str = "OIDN_LIBRARY";

    /// Those of this machine: what the environment names; the folder that the user has named, if there is one; beside
    /// the program; Blender's; where the system looks.
    pub fn of_machine(folder: Option<PathBuf>) -> Self {
        let beside = env::current_exe().ok();
        let beside = beside.as_deref().and_then(Path::parent).map(Path::to_owned);
        let home = env::var_os(if cfg!(windows) { "USERPROFILE" } else { "HOME" });
        let home = home.map(PathBuf::from);
        Self {
            library: env::var_os(Self::LIBRARY),
            folder,
            folders: beside
                .into_iter()
                .chain(blenders(home.as_deref()))
                .collect(),
            system: true,
        }
    }

    /// The files to try, in order, and whether the user has named them.
    fn candidates(&self) -> (Vec<PathBuf>, bool) {
        if let Some(library) = &self.library {
            return (vec![PathBuf::from(library)], true);
        }
        if let Some(folder) = &self.folder {
            let mut files = within(folder);
            let there = files.iter().position(|file| file.is_file()).unwrap_or(0);
            return (vec![files.swap_remove(there)], true);
        }
        let mut files: Vec<PathBuf> = self.folders.iter().flat_map(|f| within(f)).collect();
        files.retain(|file| file.is_file());
        if self.system {
            files.extend(FILE_NAMES.iter().map(PathBuf::from));
        }
        (files, false)
    }
}

fn within(folder: &Path) -> Vec<PathBuf> {
    FILE_NAMES.iter().map(|name| folder.join(name)).collect()
}

/// What became of the search for a library.
#[derive(Debug, Clone)]
pub struct Searched {
    /// A library with a device that works.
    pub found: Result<Arc<Library>, DenoiseError>,
    /// Why earlier places have none that can be used, where they have one at all.
    pub refused: Vec<DenoiseError>,
}

/// Looks for a library that can be used, by making a device of it.
pub fn find(places: &Places) -> Searched {
    let mut refused = Vec::new();
    if places
        .library
        .as_ref()
        .is_some_and(|library| library.is_empty())
    {
        let found = Err(DenoiseError::SwitchedOff);
        return Searched { found, refused };
    }
    let (files, is_named) = places.candidates();
    for file in files {
        let opened =
            Library::open(&file).and_then(|library| Denoiser::new(&library).map(|_| library));
        match opened {
            Ok(library) => {
                let found = Ok(library);
                return Searched { found, refused };
            }
            Err(error) if is_named => {
                let found = Err(error);
                return Searched { found, refused };
            }
            // The system has no library of that name.
            Err(DenoiseError::Load { path, .. }) if path.parent() == Some(Path::new("")) => {}
            Err(error) => refused.push(error),
        }
    }
    let found = Err(DenoiseError::NotFound);
    Searched { found, refused }
}

/// Folders where Blender, which brings the library along, may be installed; those that are there.
fn blenders(home: Option<&Path>) -> Vec<PathBuf> {
    // A folder, what the names of those in it begin with, and where the library lies in these.
    let mut places: Vec<(PathBuf, &str, &str)> = Vec::new();
    if cfg!(windows) {
        if let Some(programs) = env::var_os("ProgramFiles") {
            let programs = PathBuf::from(programs).join("Blender Foundation");
            places.push((programs, "Blender", "blender.shared"));
        }
    } else if cfg!(target_os = "macos") {
        let of_home = home.map(|home| home.join("Applications"));
        for folder in of_home.into_iter().chain([PathBuf::from("/Applications")]) {
            places.push((folder, "Blender", "Contents/Resources/lib"));
        }
    } else {
        let folders = ["", "Apps", "Applications", "bin", "opt", "Downloads"];
        let of_home = home.map(|home| folders.map(|folder| home.join(folder)));
        for folder in of_home
            .into_iter()
            .flatten()
            .chain(["/opt".into(), "/usr/local".into()])
        {
            places.push((folder, "blender", "lib"));
        }
        places.push(("/snap/blender".into(), "current", "lib"));
        let flatpak = "/var/lib/flatpak/app/org.blender.Blender/current/active/files";
        places.push((flatpak.into(), "blender", "lib"));
    }
    let mut found = Vec::new();
    for (folder, name, library) in places {
        let Ok(entries) = fs::read_dir(folder) else {
            continue;
        };
        let of_name = entries.flatten().filter(|entry| {
            let entry = entry.file_name();
            entry.to_string_lossy().starts_with(name)
        });
        let mut here: Vec<PathBuf> = of_name.map(|entry| entry.path().join(library)).collect();
        here.retain(|folder| folder.is_dir());
        // Newer versions have higher numbers.
        here.sort_unstable_by(|a, b| b.cmp(a));
        found.extend(here);
    }
    found
}
