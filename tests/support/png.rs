//! PNG files that tests put together.

/// A PNG's bytes with chunks inserted behind its header: the signature has 8 bytes, IHDR 12 and 13 of content.
pub fn with_chunks(mut png: Vec<u8>, chunks: &[Vec<u8>]) -> Vec<u8> {
    png.splice(33..33, chunks.concat());
    png
}
