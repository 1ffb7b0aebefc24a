//! The loops that a ray has solved: a small hash set that is emptied by a new number for the ray.

/// Indices of loops.
#[derive(Debug)]
pub(super) struct Mailbox {
    /// Each a loop's index and the ray that put it there; a power of two.
    slots: Vec<[u32; 2]>,
    ray: u32,
    /// Loops of this ray.
    count: usize,
}

impl Default for Mailbox {
    #[inline(always)]
    fn default() -> Self {
        Self {
            slots: vec![[0; 2]; 128],
            ray: 0,
            count: 0,
        }
    }
}

impl Mailbox {
    /// Forgets everything, for another ray.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
        self.ray = self.ray.wrapping_add(1);
        if self.ray == 0 {
            // Numbers begin again: those of four thousand million rays ago must not count.
            self.slots.fill([0; 2]);
            self.ray = 1;
        }
    }

    /// Whether it holds `index`; if not, it does from now on.
    #[inline(always)]
    pub fn has(&mut self, index: u32) -> bool {
        let mask = self.slots.len() - 1;
        let mut at = index as usize & mask;
        loop {
            let slot = &mut self.slots[at];
            if slot[1] != self.ray {
                *slot = [index, self.ray];
                self.count += 1;
                if self.count * 2 > self.slots.len() {
                    self.grow();
                }
                return false;
            }
            if slot[0] == index {
                return true;
            }
            at = (at + 1) & mask;
        }
    }

    #[cold]
    fn grow(&mut self) {
        let size = 2 * self.slots.len();
        let old = std::mem::replace(&mut self.slots, vec![[0; 2]; size]);
        self.count = 0;
        for [index, ray] in old {
            if ray == self.ray {
                self.has(index);
            }
        }
    }
}
