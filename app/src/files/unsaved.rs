//! Unsaved designs, kept until they are saved: a bundle with a member more, which tells what the design belongs to.
//!
//! Every window keeps its own file, `NAME.towel`, and holds a lock on `NAME.lock` for as long as it lives; the system
//! gives the lock up when the process ends, however it ends. So a file whose lock can be had was left behind.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use renderer_core::design::{Design, ImageSlot};
use serde::{Deserialize, Serialize};

use super::bundle::{BUNDLE_ENDING, Packer, unpack};
use super::image_words::words;
use super::preset::{Reading, Source};
use super::zip::Archive;
use super::{Carried, FileError, Origin, Stamp, write_atomically};

/// The member that tells what the design belongs to.
const ABOUT: &str = "unsaved.json";
/// Its largest size, bytes.
const LARGEST_ABOUT: usize = 1 << 20;
/// Ending of locks.
const LOCK_ENDING: &str = "lock";
/// Locks without a design are swept away after this long; a window may be about to write its design.
const LONG_AGO: Duration = Duration::from_secs(24 * 3600);

/// A design that is in no file, and what it belongs to.
#[derive(Debug, Clone)]
pub struct Unsaved {
    /// The design.
    pub design: Design,
    /// Its images that lie in no folder.
    pub carried: Carried,
    /// The file it was read from or last saved to.
    pub path: Option<PathBuf>,
    /// Its name, if it has one without a file.
    pub name: Option<String>,
    /// The file's state when it was read or written.
    pub stamp: Option<Stamp>,
}

#[derive(Serialize, Deserialize)]
struct About {
    /// The path's bytes: it need not be text.
    path: Option<Vec<u8>>,
    name: Option<String>,
    stamp: Option<Stamp>,
    /// Fields of images that were painted here: they have no file of their own to be named by. Where an earlier program
    /// has not written this, they keep the names that they have in the bundle.
    #[serde(default)]
    own_images: Vec<String>,
}

/// The place where a window keeps its unsaved design.
#[derive(Debug)]
pub struct AutosaveFile {
    file: PathBuf,
    lock_file: PathBuf,
    _lock: File,
}

impl AutosaveFile {
    /// A place of its own in `folder`, which is made if need be.
    ///
    /// # Errors
    /// When the folder or the disk refuses.
    pub fn new(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let now = now.unwrap_or_default().as_nanos();
        let file = folder.join(format!("{}-{now}.{BUNDLE_ENDING}", std::process::id()));
        let lock_file = file.with_extension(LOCK_ENDING);
        let lock = File::create_new(&lock_file)?;
        // A file system without locks keeps the design all the same.
        let _ = lock.try_lock();
        Ok(Self {
            file,
            lock_file,
            _lock: lock,
        })
    }

    /// Writes the design.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, unsaved: &Unsaved, packer: &mut Packer) -> Result<(), String> {
        let packed = packer.pack(&unsaved.design, &unsaved.carried, Path::new(""), None)?;
        let about = About {
            path: unsaved.path.as_deref().map(bytes_of),
            name: unsaved.name.clone(),
            stamp: unsaved.stamp,
            own_images: ImageSlot::of(&unsaved.design)
                .filter(|slot| words(*slot).owner_keyword.is_some())
                .filter(|slot| slot.path(&unsaved.design).is_none())
                .map(|slot| slot.field().into_owned())
                .collect(),
        };
        let about = serde_json::to_vec(&about).map_err(|error| error.to_string())?;
        let archive = packed.archive_with(Some((ABOUT, &about)))?;
        write_atomically(&self.file, &archive).map_err(|error| error.to_string())
    }

    /// Removes the design: it is saved, or given up.
    pub fn clear(&self) {
        // Not there, in most cases.
        let _ = fs::remove_file(&self.file);
    }
}

impl Drop for AutosaveFile {
    fn drop(&mut self) {
        if !self.file.exists() {
            let _ = fs::remove_file(&self.lock_file);
        }
    }
}

/// A design that a program which has ended left behind. While this lives, no other window is offered it.
#[derive(Debug)]
pub struct RecoveryFile {
    keep: AutosaveFile,
}

impl RecoveryFile {
    /// The latest of `folder`.
    pub fn find(folder: &Path) -> Option<Self> {
        let entries = fs::read_dir(folder).ok()?.flatten();
        let mut found: Vec<(SystemTime, PathBuf)> = entries
            .filter_map(|entry| {
                let modified = entry.metadata().ok()?.modified().ok()?;
                Some((modified, entry.path()))
            })
            .collect();
        found.sort();
        let has_ending = |path: &Path, ending| path.extension().is_some_and(|e| e == ending);
        for (modified, path) in &found {
            let is_old = modified.elapsed().is_ok_and(|age| age > LONG_AGO);
            let is_alone = !path.with_extension(BUNDLE_ENDING).exists();
            if has_ending(path, LOCK_ENDING) && is_old && is_alone && lock(path).is_some() {
                let _ = fs::remove_file(path);
            }
        }
        let mut designs = found.into_iter().rev().map(|(_, path)| path);
        designs.find_map(|file| {
            if !has_ending(&file, BUNDLE_ENDING) {
                return None;
            }
            let lock_file = file.with_extension(LOCK_ENDING);
            let lock = lock(&lock_file)?;
            let keep = AutosaveFile {
                file,
                lock_file,
                _lock: lock,
            };
            Some(Self { keep })
        })
    }

    /// The file that has it.
    pub fn file(&self) -> &Path {
        &self.keep.file
    }

    /// When it was written.
    pub fn written(&self) -> Option<SystemTime> {
        fs::metadata(&self.keep.file).ok()?.modified().ok()
    }

    /// Reads it.
    ///
    /// # Errors
    /// When the file is broken.
    pub fn read(&self) -> Result<Unsaved, FileError> {
        let path = &self.keep.file;
        let bytes = fs::read(path).map_err(|source| FileError::Read {
            path: path.clone(),
            source,
        })?;
        let broken = |what: String| FileError::Bundle {
            path: path.clone(),
            what,
        };
        let about =
            Archive::open(&bytes).and_then(|mut archive| archive.read(ABOUT, LARGEST_ABOUT));
        let about = about
            .map_err(broken)?
            .ok_or_else(|| broken(format!("is no unsaved design: it has no {ABOUT}")))?;
        let about: About = serde_json::from_slice(&about)
            .map_err(|error| broken(format!("is broken: its {ABOUT}: {error}")))?;
        let unpacked = unpack(&bytes).map_err(broken)?;
        let source = Source::new(path, Origin::Bundle, unpacked.carried);
        let mut opened = source.open(&unpacked.text, Reading::default())?;
        for slot in ImageSlot::of(&opened.design) {
            if about.own_images.iter().any(|field| *field == slot.field()) {
                slot.set_path(&mut opened.design, None);
            }
        }
        Ok(Unsaved {
            design: opened.design,
            carried: opened.carried,
            path: about.path.and_then(path_of),
            name: about.name,
            stamp: about.stamp,
        })
    }

    /// Removes it.
    pub fn discard(self) {
        self.keep.clear();
    }

    /// Puts it aside so that it is not offered again, but is not lost; returns where it is.
    ///
    /// # Errors
    /// When it cannot be renamed.
    pub fn set_aside(self) -> io::Result<PathBuf> {
        let aside = self.keep.file.with_extension("broken");
        fs::rename(&self.keep.file, &aside)?;
        Ok(aside)
    }
}

/// The lock, if no living window has it.
fn lock(path: &Path) -> Option<File> {
    let file = File::options()
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .ok()?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => None,
        // A file system without locks: no one can be distinguished, and nothing should be lost.
        Ok(()) | Err(TryLockError::Error(_)) => Some(file),
    }
}

#[cfg(unix)]
fn bytes_of(path: &Path) -> Vec<u8> {
    use std::os::unix::ffi::OsStrExt;
    path.as_os_str().as_bytes().to_vec()
}

#[cfg(unix)]
fn path_of(bytes: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    Some(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn bytes_of(path: &Path) -> Vec<u8> {
    path.to_string_lossy().into_owned().into_bytes()
}

#[cfg(not(unix))]
fn path_of(bytes: Vec<u8>) -> Option<PathBuf> {
    String::from_utf8(bytes).ok().map(PathBuf::from)
}
