// A line in the coordinates of a loop (MODEL.md §4): where it is between the loop's side faces.

// A loop as a line sees it. Projected along n̂ a point has coordinates p = u′(1 + αv′), q = v′(1 + βu′) in the basis
// (b, c), u′ = u − ½, v′ = v − ½; p, q and the height z over their plane are linear along the line, and
// w·h = z − (A·n̂)u′v′.
struct LoopLine {
    // Where the line is nearest to the patch's middle: far from the ray's origin products would lose their digits.
    t_near: f32,
    // (p, q, z) there, and their changes in a millimetre.
    value: vec3<f32>,
    slope: vec3<f32>,
    alpha: f32,
    beta: f32,
    // A·n̂.
    lift: f32,
}

fn loop_line(ray: Ray, listed: Listed) -> LoopLine {
    let shape = load_patch(listed.index);
    let b = shape.half_base + shape.half_top;
    let c = shape.axis;
    let twist = 2.0 * (shape.half_top - shape.half_base);
    let product = cross(b, c);
    let normal = product * inverseSqrt(max(dot(product, product), 1.0e-30));
    let per_area = 1.0 / max(dot(product, normal), SMALLEST_AREA);
    let b_dual = cross(c, normal) * per_area;
    let c_dual = cross(normal, b) * per_area;
    let to_middle = shape.middle + 0.5 * c - origin_in_cell(ray, listed.cell);
    let t_near = dot(to_middle, ray.direction);
    let nearest = t_near * ray.direction - to_middle;
    return LoopLine(
        t_near,
        vec3<f32>(dot(nearest, b_dual), dot(nearest, c_dual), dot(nearest, normal)),
        vec3<f32>(dot(ray.direction, b_dual), dot(ray.direction, c_dual), dot(ray.direction, normal)),
        dot(twist, b_dual),
        dot(twist, c_dual),
        dot(twist, normal),
    );
}

// (u, v, w) at a distance at which the line is inside the loop or next to it.
fn place_on(line: LoopLine, t: f32) -> vec3<f32> {
    let x = line.value + (t - line.t_near) * line.slope;
    let linear = 1.0 + line.alpha * x.y - line.beta * x.x;
    let u = 2.0 * x.x / max(linear + sqrt(max(linear * linear + 4.0 * line.beta * x.x, 0.0)), 1.0e-6);
    let v = x.y / max(1.0 + line.beta * u, 1.0e-6);
    return vec3<f32>(u + 0.5, v + 0.5, (x.z - u * v * line.lift) / scene.thickness);
}

// (value, slope) of a linear function that is 0 on the plane of constant u, and positive on the side of larger u.
fn over_u(line: LoopLine, u: f32) -> vec2<f32> {
    let s = u - 0.5;
    let stretch = 1.0 + line.beta * s;
    return vec2<f32>(
        line.value.x * stretch - s * (stretch + line.alpha * line.value.y),
        line.slope.x * stretch - s * line.alpha * line.slope.y,
    );
}

fn over_v(line: LoopLine, v: f32) -> vec2<f32> {
    let s = v - 0.5;
    let stretch = 1.0 + line.alpha * s;
    return vec2<f32>(
        line.value.y * stretch - s * (stretch + line.beta * line.value.x),
        line.slope.y * stretch - s * line.beta * line.slope.x,
    );
}

// A slope below this, 1/mm, moves less than f32 resolves over any way through a loop.
const LEVEL: f32 = 1.0e-9;
// Where `over` is 0.
fn zero_of(line: LoopLine, over: vec2<f32>) -> f32 {
    return select(FAR, line.t_near - over.x / over.y, abs(over.y) > LEVEL);
}

// The part of a range of distances in which `over` is positive.
fn clip_positive(line: LoopLine, range: vec2<f32>, over: vec2<f32>) -> vec2<f32> {
    if abs(over.y) <= LEVEL {
        return select(range, vec2<f32>(FAR, -FAR), over.x < 0.0);
    }
    let zero = line.t_near - over.x / over.y;
    if over.y > 0.0 {
        return vec2<f32>(max(range.x, zero), range.y);
    }
    return vec2<f32>(range.x, min(range.y, zero));
}

// The part between the side faces.
fn between_sides(line: LoopLine) -> vec2<f32> {
    var range = clip_positive(line, vec2<f32>(-FAR, FAR), over_u(line, 0.0));
    range = clip_positive(line, range, -over_u(line, 1.0));
    range = clip_positive(line, range, over_v(line, 0.0));
    return clip_positive(line, range, -over_v(line, 1.0));
}
