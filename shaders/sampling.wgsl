// Random numbers: integer hash, Owen-scrambled Sobol points, a small generator. Twin of renderer-core/src/sampling,
// equal to it bit by bit; sources and reasons are given there.

struct Pcg { state: u32 }

fn hash(value: u32) -> u32 {
    var x = value;
    x ^= x >> 16u;
    x *= 0x21f0aaadu;
    x ^= x >> 15u;
    x *= 0xd35a2d97u;
    return x ^ (x >> 15u);
}

fn hash_with(seed: u32, value: u32) -> u32 {
    return hash((seed * 0x9e3779b9u) ^ hash(value + 0x85ebca6bu));
}

// Seed of a pixel of the whole picture.
fn pixel_seed(seed: u32, pixel: vec2<u32>) -> u32 {
    return hash_with(hash_with(hash(seed), pixel.x), pixel.y);
}

fn owen_scramble(value: u32, seed: u32) -> u32 {
    var x = reverseBits(value);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

// The first four Sobol dimensions of point `index`.
fn sobol(index: u32) -> vec4<u32> {
    var point = vec4<u32>(reverseBits(index), 0u, 0u, 0u);
    var v1 = 0x80000000u;
    var v2 = 0x80000000u;
    var v2_next = 0xc0000000u;
    var v3 = 0x80000000u;
    var v3_next = 0xc0000000u;
    var v3_after = 0x20000000u;
    for (var rest = index; rest != 0u; rest >>= 1u) {
        let used = 0u - (rest & 1u);
        point ^= vec4<u32>(0u, v1, v2, v3) & vec4<u32>(used);
        v1 ^= v1 >> 1u;
        let v2_new = v2_next ^ v2 ^ (v2 >> 2u);
        v2 = v2_next;
        v2_next = v2_new;
        let v3_new = v3_next ^ v3 ^ (v3 >> 3u);
        v3 = v3_next;
        v3_next = v3_after;
        v3_after = v3_new;
    }
    return point;
}

// 24 high bits as a number in [0, 1), exact.
fn unit_float(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

fn set_at(bounce: u32, purpose: u32) -> u32 {
    return SETS_PER_BOUNCE * bounce + purpose;
}

// Which scramble a sample belongs to: they take turns by runs.
fn scramble_of(sample: u32) -> u32 {
    return sample / RUN % SCRAMBLES;
}

fn owen_bits(seed_of_pixel: u32, sample: u32, set_number: u32) -> vec4<u32> {
    let seed = hash_with(hash_with(seed_of_pixel, scramble_of(sample)), set_number);
    let place = sample / (RUN * SCRAMBLES) * RUN + sample % RUN;
    let point = sobol(owen_scramble(place, seed));
    return vec4<u32>(
        owen_scramble(point.x, hash_with(seed, 1u)),
        owen_scramble(point.y, hash_with(seed, 2u)),
        owen_scramble(point.z, hash_with(seed, 3u)),
        owen_scramble(point.w, hash_with(seed, 4u)),
    );
}

fn random_bits(seed_of_pixel: u32, sample: u32, set_number: u32) -> vec4<u32> {
    let seed = hash_with(hash_with(seed_of_pixel, sample), set_number);
    return vec4<u32>(hash_with(seed, 1u), hash_with(seed, 2u), hash_with(seed, 3u), hash_with(seed, 4u));
}

fn sample_set(seed_of_pixel: u32, sample: u32, set_number: u32) -> vec4<f32> {
    var bits: vec4<u32>;
    if OWEN {
        bits = owen_bits(seed_of_pixel, sample, set_number);
    } else {
        bits = random_bits(seed_of_pixel, sample, set_number);
    }
    return vec4<f32>(unit_float(bits.x), unit_float(bits.y), unit_float(bits.z), unit_float(bits.w));
}

fn pcg_new(seed_of_pixel: u32, sample: u32) -> Pcg {
    return Pcg(hash_with(seed_of_pixel ^ 0x7a3c91e5u, sample));
}

fn pcg_next(random: ptr<function, Pcg>) -> f32 {
    let state = (*random).state * 747796405u + 2891336453u;
    (*random).state = state;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return unit_float((word >> 22u) ^ word);
}
