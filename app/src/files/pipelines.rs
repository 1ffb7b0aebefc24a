//! Compiled pipelines in a file for each kind of device: magic, checksum, then what the driver gave out. A file that is
//! missing, broken, or of another program is as good as none.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use renderer_core::gpu::GpuContext;

use super::write_atomically_with;

/// Begins every file.
const MAGIC: &[u8; 8] = b"towelpl1";
/// A driver's pipelines are some hundred kB each; files larger than this are not ours.
const LARGEST: u64 = 256 << 20;

/// Starts a device from the pipelines kept in `folder`, and keeps there what it makes. Never fails: at worst everything
/// is compiled anew.
pub fn keep_pipelines(context: GpuContext, folder: &Path) -> GpuContext {
    let Some(name) = context.pipelines_name() else {
        return context;
    };
    let path = folder.join(name);
    let kept = match read(&path) {
        Ok(kept) => Some(kept),
        Err(error) => {
            if error.kind() != io::ErrorKind::NotFound {
                tracing::info!("{}: passed over: {error}", path.display());
            }
            None
        }
    };
    context.keep_pipelines(kept, move |bytes| {
        let written = path.parent().map_or(Ok(()), fs::create_dir_all);
        let written = written.map_err(|error| error.to_string()).and_then(|()| {
            write_atomically_with(&path, |file| {
                file.write_all(MAGIC)?;
                file.write_all(&crc32fast::hash(bytes).to_le_bytes())?;
                file.write_all(bytes)
            })
            .map_err(|error| error.to_string())
        });
        if let Err(error) = written {
            tracing::info!("{}: not kept: {error}", path.display());
        }
    })
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    if file.metadata()?.len() > LARGEST {
        return Err(io::Error::other("is larger than any such file"));
    }
    let mut header = [0; MAGIC.len() + 4];
    file.read_exact(&mut header)?;
    let (magic, checksum) = header.split_at(MAGIC.len());
    let mut bytes = Vec::new();
    file.take(LARGEST).read_to_end(&mut bytes)?;
    if magic != MAGIC || checksum != crc32fast::hash(&bytes).to_le_bytes() {
        return Err(io::Error::other("is not one of ours, or broken"));
    }
    Ok(bytes)
}
