//! Files changed at random, the same way on every machine: what a disk, a download or an attacker makes of them.

/// A source of changes, from a fixed seed (SplitMix64).
pub struct Mutator(u64);

/// Numbers that sizes, counts and offsets go wrong at.
const EDGES: [u32; 12] = [
    0,
    1,
    2,
    7,
    0x7f,
    0x80,
    0xff,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
];

/// Values that a field is set to.
const VALUES: [&str; 18] = [
    "0",
    "-1",
    "-0.0",
    "1",
    "2",
    "0.5",
    "7",
    "64",
    "1e300",
    "1e-300",
    "nan",
    "-inf",
    "9223372036854775807",
    "true",
    "\"\"",
    "\"../../../etc/passwd\"",
    "[[7]]",
    "{}",
];

impl Mutator {
    /// The changes of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `bound`, which is above 0.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }

    /// A file with one to five changes; `others` are files that parts are taken from. Most changes fall near the start,
    /// where headers are.
    pub fn mutated(&mut self, file: &[u8], others: &[&[u8]]) -> Vec<u8> {
        let mut file = file.to_vec();
        for _ in 0..=self.below(5) {
            self.change(&mut file, others);
        }
        file
    }

    /// A text of lines `name = value` with one to three lines changed as a hand or another program changes them.
    pub fn mutated_text(&mut self, text: &[u8]) -> Vec<u8> {
        let text = String::from_utf8_lossy(text);
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        for _ in 0..=self.below(3) {
            if !lines.is_empty() {
                self.change_line(&mut lines);
            }
        }
        lines.join("\n").into_bytes()
    }

    fn change_line(&mut self, lines: &mut Vec<String>) {
        let (at, other) = (self.below(lines.len()), self.below(lines.len()));
        let name = lines[at].split('=').next().unwrap_or_default().trim();
        let of_other = lines[other].split('=').nth(1).unwrap_or("0").trim();
        match self.below(8) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[other].clone()),
            2 => lines.swap(at, other),
            3 | 4 => lines[at] = format!("{name} = {of_other}"),
            _ => lines[at] = format!("{name} = {}", VALUES[self.below(VALUES.len())]),
        }
    }

    fn place(&mut self, length: usize) -> usize {
        match self.below(2) {
            0 => self.below(length.min(96)),
            _ => self.below(length),
        }
    }

    fn change(&mut self, file: &mut Vec<u8>, others: &[&[u8]]) {
        if file.is_empty() {
            file.push(self.next() as u8);
            return;
        }
        let at = self.place(file.len());
        let length = 1 + self.below(16.min(file.len() - at));
        match self.below(10) {
            0 | 1 => file[at] ^= 1 << self.below(8),
            2 => file[at] = self.next() as u8,
            3 | 4 => {
                let edge = EDGES[self.below(EDGES.len())];
                let size = [1, 2, 4][self.below(3)];
                let bytes = match self.below(2) {
                    0 => edge.to_le_bytes()[..size].to_vec(),
                    _ => edge.to_be_bytes()[4 - size..].to_vec(),
                };
                let end = (at + size).min(file.len());
                file[at..end].copy_from_slice(&bytes[..end - at]);
            }
            5 => file.truncate(at),
            6 => drop(file.drain(at..at + length)),
            7 => {
                let part = file[at..at + length].to_vec();
                file.splice(at..at, part);
            }
            8 => file[at..at + length].fill(0),
            _ => {
                let other = others[self.below(others.len())];
                if !other.is_empty() {
                    let from = self.below(other.len());
                    let part = &other[from..(from + length).min(other.len())];
                    file.splice(at..at + length, part.iter().copied());
                }
            }
        }
    }
}
