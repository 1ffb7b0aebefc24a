//! Opening what somebody names as an input: files, and pipes where a design is read. What is neither is refused at
//! once, and nothing is read beyond what it may hold: devices and programs that write for ever fill no memory.

use std::fs::{self, File, FileType};
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

use super::{LARGEST_PRESET, bundle::LARGEST_BUNDLE};

/// What a PNG begins with.
pub(super) const PNG: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// What a zip archive begins with: its first member, or its end where it has none.
const ZIP: [[u8; 4]; 2] = [*b"PK\x03\x04", *b"PK\x05\x06"];
/// How long to wait for somebody to open the other end of a pipe with a name.
const WRITER_PATIENCE: Duration = Duration::from_secs(5);

/// What a file holds by its first bytes, whatever its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// A zip archive.
    Zip,
    /// A PNG.
    Png,
    /// Something else: text, or nothing that is known.
    Other,
}

/// A file or what came through a pipe, at its beginning.
pub(super) enum Input {
    File(BufReader<File>),
    Piped(Cursor<Vec<u8>>),
}

impl Input {
    /// Opens a file, or reads a pipe to its end.
    ///
    /// # Errors
    /// When it cannot be opened, is neither a file nor a pipe, or a pipe brings more than a design may have.
    pub fn open(path: &Path) -> io::Result<Self> {
        let kind = fs::metadata(path)?.file_type();
        if kind.is_file() {
            return Ok(Self::File(BufReader::new(File::open(path)?)));
        }
        if !is_pipe(kind) {
            return Err(refused(kind));
        }
        let mut pipe = open_pipe(path)?;
        let mut bytes = Vec::new();
        (&mut pipe).take(PNG.len() as u64).read_to_end(&mut bytes)?;
        let most = match content_of(&bytes) {
            Content::Zip | Content::Png => LARGEST_BUNDLE,
            Content::Other => LARGEST_PRESET,
        };
        (&mut pipe).take(most).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most {
            return Err(too_large(most));
        }
        Ok(Self::Piped(Cursor::new(bytes)))
    }

    /// What it holds.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn content(&mut self) -> io::Result<Content> {
        let mut start = Vec::new();
        self.take(PNG.len() as u64).read_to_end(&mut start)?;
        self.seek(SeekFrom::Start(0))?;
        Ok(content_of(&start))
    }

    /// All of it, from where it stands.
    ///
    /// # Errors
    /// When it cannot be read, or is larger than `most` bytes.
    pub fn read_all(&mut self, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.take(most + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most {
            return Err(too_large(most));
        }
        Ok(bytes)
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.read(buffer),
            Self::Piped(bytes) => bytes.read(buffer),
        }
    }
}

impl BufRead for Input {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self {
            Self::File(file) => file.fill_buf(),
            Self::Piped(bytes) => bytes.fill_buf(),
        }
    }

    fn consume(&mut self, amount: usize) {
        match self {
            Self::File(file) => file.consume(amount),
            Self::Piped(bytes) => bytes.consume(amount),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Piped(bytes) => bytes.seek(to),
        }
    }
}

/// Opens a file that must be one: not a folder, a device or a pipe.
///
/// # Errors
/// When it cannot be opened, or is no file.
pub(super) fn open_file(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() {
        File::open(path)
    } else {
        Err(refused(kind))
    }
}

/// A whole file that must be one, of at most so many bytes.
///
/// # Errors
/// As [`open_file`], when it cannot be read, or is larger.
pub(super) fn read_file(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    Input::File(BufReader::new(open_file(path)?)).read_all(most)
}

fn content_of(start: &[u8]) -> Content {
    if start == PNG {
        Content::Png
    } else if ZIP.iter().any(|zip| start.starts_with(zip)) {
        Content::Zip
    } else {
        Content::Other
    }
}

fn too_large(most: u64) -> io::Error {
    io::Error::other(format!(
        "it is larger than {most} bytes, the most that is read"
    ))
}

fn refused(kind: FileType) -> io::Error {
    let what = if kind.is_dir() {
        "it is a folder"
    } else if is_pipe(kind) {
        "it is a pipe, no file"
    } else {
        "it is a device, no file"
    };
    io::Error::other(what)
}

#[cfg(unix)]
fn is_pipe(kind: FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: FileType) -> bool {
    false
}

/// Opens a pipe. One with a name blocks until it is opened for writing too, which may never be: waited for on another
/// thread, which is left behind then.
fn open_pipe(path: &Path) -> io::Result<File> {
    let (sender, opened) = channel();
    let path = path.to_owned();
    let opening = move || {
        // Nobody waits any more when it took too long.
        let _ = sender.send(File::open(path));
    };
    std::thread::Builder::new()
        .name("pipe".into())
        .spawn(opening)?;
    opened.recv_timeout(WRITER_PATIENCE).unwrap_or_else(|_| {
        let seconds = WRITER_PATIENCE.as_secs();
        Err(io::Error::other(format!(
            "it is a pipe that nothing wrote to within {seconds} seconds"
        )))
    })
}
