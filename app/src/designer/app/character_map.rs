//! Whether a font has a character: its character map (the table `cmap` of TrueType and OpenType), of the two forms that
//! fonts of today have, segments of 16 bits (format 4) and groups of 32 (format 12).

/// Whether a face of a font file has a glyph for a character.
pub fn has_glyph(font: &[u8], face: u32, character: char) -> bool {
    glyph(font, face, u32::from(character)).is_some_and(|glyph| glyph != 0)
}

fn glyph(font: &[u8], face: u32, character: u32) -> Option<u32> {
    let offsets = match font.get(..4)? {
        // A collection of faces.
        b"ttcf" => long(font, 12 + 4 * face as usize)? as usize,
        _ => 0,
    };
    let tables = usize::from(short(font, offsets + 4)?);
    let mut records = (0..tables).map(|index| offsets + 12 + 16 * index);
    let record = records.find(|at| font.get(*at..*at + 4) == Some(b"cmap"))?;
    let map = font.get(long(font, record + 8)? as usize..)?;
    let count = usize::from(short(map, 2)?);
    let of_form = |wanted: u16| {
        let mut maps = (0..count).filter_map(|index| map.get(long(map, 8 + 8 * index)? as usize..));
        maps.find(|map| short(map, 0) == Some(wanted))
    };
    match (of_form(12), of_form(4)) {
        (Some(groups), _) => in_groups(groups, character),
        (None, Some(segments)) => in_segments(segments, u16::try_from(character).ok()?),
        (None, None) => None,
    }
}

/// Groups of first character, last character and first glyph, in their order.
fn in_groups(map: &[u8], character: u32) -> Option<u32> {
    let (mut low, mut high) = (0, long(map, 12)? as usize);
    while low < high {
        let middle = usize::midpoint(low, high);
        let at = 16 + 12 * middle;
        let (first, last) = (long(map, at)?, long(map, at + 4)?);
        if character > last {
            low = middle + 1;
        } else if character < first {
            high = middle;
        } else {
            return long(map, at + 8)?.checked_add(character - first);
        }
    }
    None
}

/// Segments: last characters, first characters, what is added, and where the glyphs are listed, each a list of its own.
fn in_segments(map: &[u8], character: u16) -> Option<u32> {
    let count = usize::from(short(map, 6)? / 2);
    let lasts = 14;
    let firsts = lasts + 2 * count + 2;
    let (added, listed) = (firsts + 2 * count, firsts + 4 * count);
    let segment = (0..count)
        .find(|index| short(map, lasts + 2 * index).is_some_and(|last| last >= character))?;
    let first = short(map, firsts + 2 * segment)?;
    if character < first {
        return None;
    }
    let added = short(map, added + 2 * segment)?;
    let list = listed + 2 * segment;
    let glyph = match short(map, list)? {
        0 => character.wrapping_add(added),
        offset => match short(
            map,
            list + usize::from(offset) + 2 * usize::from(character - first),
        )? {
            0 => 0,
            glyph => glyph.wrapping_add(added),
        },
    };
    Some(u32::from(glyph))
}

fn short(bytes: &[u8], at: usize) -> Option<u16> {
    let bytes = bytes.get(at..at.checked_add(2)?)?;
    Some(u16::from_be_bytes([bytes[0], bytes[1]]))
}

fn long(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from(short(bytes, at)?) << 16 | u32::from(short(bytes, at.checked_add(2)?)?))
}
