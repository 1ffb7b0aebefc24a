//! Writing files so that they are whole or untouched: the bytes go to a temporary file in the same directory, reach the
//! disk, and replace the old file at once, so that a crash or a full disk leaves it as it was.

use std::fs;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::FileError;

/// Writes a file so that it is either whole or untouched.
///
/// # Errors
/// When the directory or the disk refuses.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_atomically_with(path, |file| file.write_all(bytes))
}

/// As [`write_atomically`], for files that are made piece by piece.
///
/// # Errors
/// When the directory or the disk refuses, or `write` does.
pub fn write_atomically_with(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), FileError> {
    replace(path, write).map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    // Through a symbolic link the file it points to is replaced, not the link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&target).is_ok_and(|existing| !existing.is_file() && !existing.is_dir()) {
        // A device or pipe (`/dev/stdout`) cannot be replaced, only written to.
        return write(&mut fs::OpenOptions::new().write(true).open(&target)?);
    }
    let mut file = BufWriter::new(temporary_beside(&target)?);
    write(&mut file)?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    sync_folder(&target)
}

/// Writes several files: all of them reach the disk before the first replaces its old one, so that a full disk leaves
/// all as they were.
///
/// # Errors
/// When a directory or the disk refuses.
pub fn write_together(files: &[(&Path, &[u8])]) -> Result<(), FileError> {
    let mut written = Vec::new();
    for &(path, bytes) in files {
        let failed = |source| FileError::Write {
            path: path.to_owned(),
            source,
        };
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if target.is_dir() {
            return Err(failed(io::Error::other("is a directory")));
        }
        let mut file = temporary_beside(&target).map_err(failed)?;
        file.write_all(bytes)
            .and_then(|()| file.as_file().sync_all())
            .map_err(failed)?;
        written.push((path, target, file));
    }
    for (path, target, file) in written {
        file.persist(&target)
            .map_err(|error| error.error)
            .and_then(|_| sync_folder(&target))
            .map_err(|source| FileError::Write {
                path: path.to_owned(),
                source,
            })?;
    }
    Ok(())
}

/// A file in the making, for what takes long to make: nameless on the disk that it will be on, so that whatever ends
/// the program leaves nothing behind.
pub struct Draft {
    file: BufWriter<fs::File>,
    path: PathBuf,
}

impl Draft {
    /// An empty file that will be `path`.
    ///
    /// # Errors
    /// When the directory refuses.
    pub fn new(path: &Path) -> Result<Self, FileError> {
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let is_device =
            fs::metadata(&target).is_ok_and(|existing| !existing.is_file() && !existing.is_dir());
        let folder = match target.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let file = if is_device {
            tempfile::tempfile()
        } else {
            tempfile::tempfile_in(folder)
        };
        Ok(Self {
            file: BufWriter::new(file.map_err(|source| write_error(path, source))?),
            path: path.to_owned(),
        })
    }

    /// Makes it the file, at once.
    ///
    /// # Errors
    /// When the directory or the disk refuses; an old file is untouched then.
    pub fn finish(self) -> Result<(), FileError> {
        let Self { file, path } = self;
        let rewound = file
            .into_inner()
            .map_err(io::IntoInnerError::into_error)
            .and_then(|mut file| file.rewind().map(|()| file));
        let mut draft = rewound.map_err(|source| write_error(&path, source))?;
        write_atomically_with(&path, |file| io::copy(&mut draft, file).map(drop))
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

/// A file that could not be written, and why.
pub fn write_error(path: &Path, source: io::Error) -> FileError {
    FileError::Write {
        path: path.to_owned(),
        source,
    }
}

/// Whether `path` could be written now, without changing it: asked before minutes of rendering.
///
/// # Errors
/// When it could not, with the reason.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    let check = || -> io::Result<()> {
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        match fs::metadata(&target) {
            Ok(existing) if existing.is_dir() => Err(io::Error::other("is a directory")),
            Ok(existing) if existing.permissions().readonly() => {
                Err(io::Error::other("is write-protected"))
            }
            Ok(existing) if !existing.is_file() => Ok(()),
            _ => temporary_beside(&target).map(drop),
        }
    };
    check().map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

/// A temporary file in the same directory, removed when dropped, with the permissions that the target has or would get.
fn temporary_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::other("is not the name of a file"))?;
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let prefix = format!(".{}.", name.to_string_lossy());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(match fs::metadata(target) {
            Ok(existing) => existing.permissions(),
            // What the process's umask leaves of it, as for any new file.
            Err(_) => fs::Permissions::from_mode(0o666),
        });
    }
    builder.tempfile_in(folder).map_err(|error| {
        // tempfile's message names its random file; only the reason matters here.
        match error.kind() {
            io::ErrorKind::NotFound if !folder.is_dir() => {
                io::Error::other(format!("there is no directory {}", folder.display()))
            }
            kind => io::Error::from(kind),
        }
    })
}

/// Makes the rename itself reach the disk.
#[cfg(unix)]
fn sync_folder(target: &Path) -> io::Result<()> {
    match target.parent() {
        Some(folder) if folder != Path::new("") => fs::File::open(folder)?.sync_all(),
        _ => fs::File::open(".")?.sync_all(),
    }
}

#[cfg(not(unix))]
fn sync_folder(_target: &Path) -> io::Result<()> {
    Ok(())
}
