//! Files in the making, and how they get their names.
//!
//! The bytes of a draft go to the folder that its file will be in, reach the disk, and then the draft itself takes the
//! place of the old file, at once: no second copy is made, so what fits once fits, and a crash or a full disk leaves the
//! old file as it was. Where the system has files without names (Linux, most file systems), a draft has none until it
//! is whole, so that whatever ends the program leaves nothing behind. Elsewhere it is a hidden file with a short name,
//! [`PREFIX`] and a number, locked as long as its program lives; one whose lock can be had was left behind by a program
//! that is dead, and is removed by the next that writes into the folder.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::FileError;
use super::write::write_error;

/// What names of drafts begin with.
const PREFIX: &str = ".towel-draft-";
/// What they end with.
const ENDING: &str = ".tmp";
/// Most names that are tried for one draft.
const MOST_NAMES: u32 = 10_000;
/// Most symbolic links that lead from one to the next, as on Linux.
const MOST_LINKS: u32 = 40;

/// Where the bytes for a path go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Target {
    /// To a file, which may not be there yet. No link: through links the file they lead to is replaced, also where there
    /// is none yet.
    File(PathBuf),
    /// Into a device or pipe (`/dev/stdout`), which cannot be replaced, only written to.
    Device(PathBuf),
}

impl Target {
    /// Of a path as it is now; what can be known to be in the way is found here, before anything is made.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        let path = follow(path)?;
        match fs::metadata(&path) {
            Ok(existing) if existing.is_dir() => Err(io::Error::other("is a directory")),
            Ok(existing) if !existing.is_file() => Ok(Self::Device(path)),
            Ok(existing) if existing.permissions().readonly() => {
                Err(io::Error::other("is write-protected"))
            }
            Ok(_) => Ok(Self::File(path)),
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            Err(_) if path.file_name().is_none() => {
                Err(io::Error::other("is not the name of a file"))
            }
            Err(_) if !folder_of(&path).is_dir() => Err(io::Error::other(format!(
                "there is no directory {}",
                folder_of(&path).display()
            ))),
            Err(_) => Ok(Self::File(path)),
        }
    }
}

/// Where symbolic links lead to, also where there is nothing yet; the path itself if it is none.
pub(super) fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    match fs::metadata(&path) {
        Ok(found) if found.is_file() || found.is_dir() => {
            return Ok(path.canonicalize().unwrap_or(path));
        }
        // What links to a pipe say is no path.
        Ok(_) => return Ok(path),
        Err(_) => {}
    }
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(to) => path = folder_of(&path).join(to),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("is a link that leads back to itself"))
}

/// The folder that a file is in.
pub(super) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// A file in the making.
pub struct Draft {
    file: BufWriter<File>,
    path: PathBuf,
    target: Target,
    name: Option<Name>,
}

impl Draft {
    /// An empty file that will be `path`.
    ///
    /// # Errors
    /// When the folder refuses, or what is there cannot be replaced.
    pub fn new(path: &Path) -> Result<Self, FileError> {
        let failed = |source| write_error(path, source);
        let target = Target::of(path).map_err(failed)?;
        let (file, name) = match &target {
            Target::Device(_) => tempfile::tempfile().map(|file| (file, None)),
            Target::File(file) => new_beside(file),
        }
        .map_err(failed)?;
        Ok(Self {
            file: BufWriter::new(file),
            path: path.to_owned(),
            target,
            name,
        })
    }

    /// Brings everything to the disk; what is left is to give the draft its file's name.
    pub(super) fn whole(self) -> Result<WholeDraft, FileError> {
        let Self {
            file,
            path,
            target,
            name,
        } = self;
        let finish = || -> io::Result<(File, Option<Name>)> {
            let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            if matches!(target, Target::File(_)) {
                sync(&file)?;
            }
            Ok((file, name))
        };
        match finish() {
            Ok((file, name)) => Ok(WholeDraft {
                file,
                path,
                target,
                name,
            }),
            Err(source) => Err(write_error(&path, source)),
        }
    }

    /// Makes it the file, at once. A whole draft that cannot become the file is kept, and the error says where.
    ///
    /// # Errors
    /// When the folder or the disk refuses; an old file is untouched then.
    pub fn finish(self) -> Result<(), FileError> {
        let mut whole = self.whole()?;
        whole.place().map_err(|source| match whole.keep() {
            Some(kept) => FileError::Kept {
                path: whole.path.clone(),
                kept,
                source,
            },
            None => write_error(&whole.path, source),
        })
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Draft {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// A draft that has everything, all of it on the disk.
pub(super) struct WholeDraft {
    file: File,
    path: PathBuf,
    target: Target,
    name: Option<Name>,
}

impl WholeDraft {
    /// The path it is for, as it was given.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives it the name of its file, in whose place it is from then on.
    pub(super) fn place(&mut self) -> io::Result<()> {
        match &self.target {
            Target::Device(device) => {
                self.file.rewind()?;
                let mut device = File::options().write(true).open(device)?;
                io::copy(&mut self.file, &mut device).map(drop)
            }
            Target::File(target) => {
                if self.name.is_none() {
                    self.name = Some(give_name(&mut self.file, folder_of(target))?);
                }
                if let Some(name) = &self.name {
                    fs::rename(&name.0, target)?;
                }
                if let Some(name) = self.name.take() {
                    name.leave();
                }
                sync_folder(folder_of(target));
                Ok(())
            }
        }
    }

    /// Keeps it under another name, since its own cannot be had; returns where it is. `None` where there is no room
    /// for it anywhere.
    fn keep(&mut self) -> Option<PathBuf> {
        let Target::File(target) = &self.target else {
            return None;
        };
        if self.name.is_none() {
            self.name = link_name(&self.file, folder_of(target));
        }
        let kept = match self.name.take() {
            Some(name) if name.0.exists() => keep_beside(&self.file, name, target)?,
            // The folder is gone, or takes no names any more.
            _ => copy_elsewhere(&mut self.file, target)?,
        };
        Some(std::path::absolute(&kept).unwrap_or(kept))
    }
}

/// Keeps a draft in its folder: under a name that tells what it is, or else where it is.
fn keep_beside(file: &File, name: Name, target: &Path) -> Option<PathBuf> {
    if let Some((_, free)) = free_name(folder_of(target), target)
        && fs::rename(&name.0, &free.0).is_ok()
    {
        name.leave();
        return Some(free.leave());
    }
    // What is write-protected is not swept away.
    let mut permissions = file.metadata().ok()?.permissions();
    permissions.set_readonly(true);
    file.set_permissions(permissions).ok()?;
    Some(name.leave())
}

/// Keeps a copy of a draft in the folder for temporary files.
fn copy_elsewhere(file: &mut File, target: &Path) -> Option<PathBuf> {
    let (mut copy, place) = free_name(&std::env::temp_dir(), target)?;
    file.rewind().ok()?;
    io::copy(file, &mut copy).ok()?;
    sync(&copy).ok()?;
    Some(place.leave())
}

/// The name of a draft, which is removed with it.
#[derive(Debug)]
struct Name(PathBuf);

impl Name {
    /// The file keeps it, or has another by now.
    fn leave(mut self) -> PathBuf {
        std::mem::take(&mut self.0)
    }
}

impl Drop for Name {
    fn drop(&mut self) {
        if self.0 != Path::new("") {
            let _ = fs::remove_file(&self.0);
        }
    }
}

/// An empty draft in the folder of `target`, with the permissions that the old file has.
fn new_beside(target: &Path) -> io::Result<(File, Option<Name>)> {
    let folder = folder_of(target);
    sweep_once(folder);
    let (file, name) = match nameless(folder) {
        Some(file) => (file, None),
        None => named(folder).map(|(file, name)| (file, Some(name)))?,
    };
    if let Ok(existing) = fs::metadata(target) {
        file.set_permissions(existing.permissions())?;
    }
    Ok((file, name))
}

/// The names of drafts in a folder, one after another.
fn names(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let process = std::process::id();
    (0..MOST_NAMES).map(move |k| folder.join(format!("{PREFIX}{process:x}-{k:x}{ENDING}")))
}

fn no_name() -> io::Error {
    io::Error::other("no name for a temporary file is free")
}

/// A draft with a name, and its lock.
fn named(folder: &Path) -> io::Result<(File, Name)> {
    for path in names(folder) {
        let file = File::options()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&path);
        match file {
            Ok(file) => {
                // A file system without locks: then nobody sweeps either.
                let _ = file.lock();
                // Who sweeps may have come between the two.
                if path.exists() {
                    return Ok((file, Name(path)));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(no_name())
}

/// A draft without a name that can be given one, where the system has such.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::TMPFILE.bits();
    let file = File::options()
        .read(true)
        .write(true)
        .custom_flags(flags.cast_signed())
        .open(folder)
        .ok()?;
    // What it will be named by.
    fs::symlink_metadata(self_link(&file)).ok()?;
    let _ = file.lock();
    Some(file)
}

#[cfg(not(target_os = "linux"))]
fn nameless(_folder: &Path) -> Option<File> {
    None
}

/// Where the system shows an open file.
#[cfg(target_os = "linux")]
fn self_link(file: &File) -> PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

/// Gives a draft that has no name the first that is free.
#[cfg(target_os = "linux")]
fn link_name(file: &File, folder: &Path) -> Option<Name> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use rustix::io::Errno;
    for path in names(folder) {
        match linkat(CWD, self_link(file), CWD, &path, AtFlags::SYMLINK_FOLLOW) {
            Ok(()) => return Some(Name(path)),
            Err(Errno::EXIST) => {}
            Err(_) => return None,
        }
    }
    None
}

#[cfg(not(target_os = "linux"))]
fn link_name(_file: &File, _folder: &Path) -> Option<Name> {
    None
}

/// A name for a draft that has none. On a file system that has files without names and yet gives them none later, it
/// takes a copy.
fn give_name(file: &mut File, folder: &Path) -> io::Result<Name> {
    if let Some(name) = link_name(file, folder) {
        return Ok(name);
    }
    let (mut copy, name) = named(folder)?;
    file.rewind()?;
    io::copy(file, &mut copy)?;
    copy.set_permissions(file.metadata()?.permissions())?;
    sync(&copy)?;
    *file = copy;
    Ok(name)
}

/// A free name like that of `target`, taken by an empty file: `picture-kept.png`, `picture-kept-2.png` and so on.
fn free_name(folder: &Path, target: &Path) -> Option<(File, Name)> {
    for k in 1..=100 {
        let mut name = OsString::from(target.file_stem()?);
        name.push("-kept");
        if k > 1 {
            name.push(format!("-{k}"));
        }
        if let Some(ending) = target.extension() {
            name.push(".");
            name.push(ending);
        }
        let path = folder.join(name);
        match File::create_new(&path) {
            Ok(file) => return Some((file, Name(path))),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(_) => return None,
        }
    }
    None
}

/// Removes what dead programs have left in a folder, once for as long as this one runs.
fn sweep_once(folder: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let place = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.insert(place) {
        sweep(folder);
    }
}

fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_draft = name.starts_with(PREFIX) && name.ends_with(ENDING);
        // A draft that is write-protected is a finished file that was kept.
        let is_left = |found: fs::Metadata| found.is_file() && !found.permissions().readonly();
        if !is_draft || !entry.metadata().is_ok_and(is_left) {
            continue;
        }
        let Ok(file) = File::options().write(true).open(entry.path()) else {
            continue;
        };
        match file.try_lock() {
            Ok(()) => {
                let _ = fs::remove_file(entry.path());
            }
            // In the making, or on a file system that cannot tell.
            Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
        }
    }
}

/// Makes a file reach the disk; file systems that do so by themselves, and cannot be asked, have done it.
fn sync(file: &File) -> io::Result<()> {
    match file.sync_all() {
        Err(error) if cannot_sync(&error) => Ok(()),
        other => other,
    }
}

fn cannot_sync(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported
    )
}

/// Makes the new name itself reach the disk, where folders can be asked to: the file is whole either way.
#[cfg(unix)]
fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

#[cfg(not(unix))]
fn sync_folder(_folder: &Path) {}
