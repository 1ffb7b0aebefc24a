//! Zip archives, as far as bundles need them: members in memory, stored or deflated, names in UTF-8.
//!
//! What is written is always the same bytes for the same members (no times, fixed order). What is read may come from
//! anywhere: every offset is checked, nothing larger than asked for is unpacked, and nothing is written anywhere, so
//! that names that lead out of the archive lead nowhere. Format: PKWARE APPNOTE 6.3.10, without ZIP64 and encryption.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;

const LOCAL: u32 = 0x0403_4b50;
const CENTRAL: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;
/// Bytes of the three headers without names, extra fields and comments.
const LOCAL_SIZE: usize = 30;
const CENTRAL_SIZE: usize = 46;
const END_SIZE: usize = 22;
/// Version of the format that is needed: deflate and folders.
const VERSION: u16 = 20;
/// Flag: the name is UTF-8.
const UTF8: u16 = 1 << 11;
/// Flag: the member is encrypted.
const ENCRYPTED: u16 = 1;
const STORED: u16 = 0;
const DEFLATED: u16 = 8;
/// 1980-01-01, the first day the format knows.
const NO_DATE: u16 = 0x21;
/// Most members of an archive that is read.
const MOST_MEMBERS: usize = 1000;

/// An archive of these members, in this order.
///
/// # Errors
/// When it would be larger than the format can say (4 GiB).
pub fn write<'a>(members: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> io::Result<Vec<u8>> {
    let too_large = |_| io::Error::other("a bundle holds at most 4 GiB");
    let mut file = Vec::new();
    let mut directory = Vec::new();
    let mut count = 0_u16;
    for (name, bytes) in members {
        let mut deflater = DeflateEncoder::new(Vec::new(), Compression::default());
        deflater.write_all(bytes)?;
        let deflated = deflater.finish()?;
        let (method, data) = if deflated.len() < bytes.len() {
            (DEFLATED, deflated.as_slice())
        } else {
            (STORED, bytes)
        };
        let offset = u32::try_from(file.len()).map_err(too_large)?;
        // The part that both headers share.
        let mut shared = Vec::new();
        for value in [VERSION, UTF8, method, 0, NO_DATE] {
            shared.extend(value.to_le_bytes());
        }
        shared.extend(crc32fast::hash(bytes).to_le_bytes());
        for length in [data.len(), bytes.len()] {
            shared.extend(u32::try_from(length).map_err(too_large)?.to_le_bytes());
        }
        let name_length = u16::try_from(name.len()).map_err(too_large)?;
        shared.extend(name_length.to_le_bytes());
        shared.extend([0; 2]);

        file.extend(LOCAL.to_le_bytes());
        file.extend(&shared);
        file.extend(name.as_bytes());
        file.extend(data);

        directory.extend(CENTRAL.to_le_bytes());
        directory.extend(VERSION.to_le_bytes());
        directory.extend(&shared);
        // Comment, disk and attributes: none.
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
        count += 1;
    }
    let start = u32::try_from(file.len()).map_err(too_large)?;
    let length = u32::try_from(directory.len()).map_err(too_large)?;
    file.extend(directory);
    file.extend(END.to_le_bytes());
    file.extend([0; 4]);
    file.extend(count.to_le_bytes());
    file.extend(count.to_le_bytes());
    file.extend(length.to_le_bytes());
    file.extend(start.to_le_bytes());
    file.extend([0; 2]);
    Ok(file)
}

/// An archive in memory, its directory read.
pub struct Archive<'a> {
    bytes: &'a [u8],
    members: Vec<Member>,
}

struct Member {
    name: String,
    flags: u16,
    method: u16,
    checksum: u32,
    packed: usize,
    unpacked: usize,
    offset: usize,
}

impl<'a> Archive<'a> {
    /// Reads the directory.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the file.
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let no_archive = || "is no bundle, or one that was cut off: it has no zip directory";
        let end = find_end(bytes).ok_or_else(no_archive)?;
        let count = usize::from(u16_at(bytes, end + 10).ok_or_else(no_archive)?);
        let mut at = u32_at(bytes, end + 16).ok_or_else(no_archive)? as usize;
        if count > MOST_MEMBERS {
            return Err(format!(
                "has {count} members, a bundle has at most {MOST_MEMBERS}"
            ));
        }
        let mut members: Vec<Member> = Vec::with_capacity(count);
        for _ in 0..count {
            let (member, next) =
                member_at(bytes, at).ok_or("is broken: its zip directory is damaged")?;
            if members.iter().any(|other| other.name == member.name) {
                return Err(format!("is broken: it holds {:?} twice", member.name));
            }
            members.push(member);
            at = next;
        }
        Ok(Self { bytes, members })
    }

    /// Unpacks a member of at most `most` bytes; `None` if there is no member of that name.
    ///
    /// # Errors
    /// What is wrong, as the end of a sentence about the file.
    pub fn read(&self, name: &str, most: usize) -> Result<Option<Vec<u8>>, String> {
        let Some(member) = self.members.iter().find(|member| member.name == name) else {
            return Ok(None);
        };
        let too_large = |size: usize| {
            format!("is not opened: its {name} has {size} bytes, allowed are at most {most}")
        };
        if member.flags & ENCRYPTED != 0 {
            return Err(format!("cannot be read: its {name} is encrypted"));
        }
        if member.unpacked > most {
            return Err(too_large(member.unpacked));
        }
        let broken = |why: &str| format!("is broken: its {name} {why}");
        let data = member
            .data(self.bytes)
            .ok_or_else(|| broken("is cut off"))?;
        let mut unpacked = Vec::new();
        match member.method {
            STORED => unpacked.extend_from_slice(data),
            DEFLATED => {
                // One byte more than it says, to see whether there is more.
                let mut inflater = DeflateDecoder::new(data).take(member.unpacked as u64 + 1);
                inflater
                    .read_to_end(&mut unpacked)
                    .map_err(|error| broken(&format!("cannot be unpacked: {error}")))?;
            }
            method => {
                return Err(format!(
                    "cannot be read: its {name} is packed by method {method}, allowed are 0 (stored) and 8 (deflated)"
                ));
            }
        }
        if unpacked.len() != member.unpacked || crc32fast::hash(&unpacked) != member.checksum {
            return Err(broken(
                "is damaged: size or checksum are not what they should be",
            ));
        }
        Ok(Some(unpacked))
    }
}

impl Member {
    fn data<'a>(&self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        if u32_at(bytes, self.offset)? != LOCAL {
            return None;
        }
        // Its own name and extra field: the directory's may be of other lengths.
        let name = usize::from(u16_at(bytes, self.offset + 26)?);
        let extra = usize::from(u16_at(bytes, self.offset + 28)?);
        let start = self.offset + LOCAL_SIZE + name + extra;
        bytes.get(start..start.checked_add(self.packed)?)
    }
}

/// The header at the end of the archive, behind which there is nothing but its comment.
fn find_end(bytes: &[u8]) -> Option<usize> {
    let last = bytes.len().checked_sub(END_SIZE)?;
    let first = last.saturating_sub(usize::from(u16::MAX));
    (first..=last).rev().find(|&at| {
        let comment = u16_at(bytes, at + 20).map(usize::from);
        u32_at(bytes, at) == Some(END) && comment == Some(last - at)
    })
}

/// The member whose directory entry is at `at`, and where the next entry is.
fn member_at(bytes: &[u8], at: usize) -> Option<(Member, usize)> {
    if u32_at(bytes, at)? != CENTRAL {
        return None;
    }
    let short = |offset| u16_at(bytes, at + offset);
    let long = |offset| u32_at(bytes, at + offset);
    let name_end = at + CENTRAL_SIZE + usize::from(short(28)?);
    let name = bytes.get(at + CENTRAL_SIZE..name_end)?;
    let next = name_end + usize::from(short(30)?) + usize::from(short(32)?);
    let member = Member {
        name: String::from_utf8_lossy(name).into_owned(),
        flags: short(8)?,
        method: short(10)?,
        checksum: long(16)?,
        packed: long(20)? as usize,
        unpacked: long(24)? as usize,
        offset: long(42)? as usize,
    };
    Some((member, next))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let bytes = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_le_bytes(bytes.try_into().ok()?))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}
