//! Which module may name which, read from the paths in the sources' text.

use std::fs;
use std::path::{Path, PathBuf};

use Arrows::{Never, Only, OnlyOf};

/// What the files below a folder must not name.
enum Arrows {
    /// These paths.
    Never(&'static str, &'static [&'static str]),
    /// Anything of another crate but these paths.
    OnlyOf(&'static str, &'static str, &'static [&'static str]),
    /// Anything of their own crate but these modules.
    Only(&'static str, &'static [&'static str]),
}

const RULES: &[Arrows] = &[
    Only("renderer-core/src/geometry", &["geometry"]),
    Only("renderer-core/src/sampling", &["sampling", "geometry"]),
    Only(
        "renderer-core/src/design",
        &["design", "geometry", "sampling"],
    ),
    Only("renderer-core/src/denoise", &["denoise", "image"]),
    Never(
        "renderer-core/src/scene",
        &[
            "crate::render",
            "crate::transport",
            "crate::cpu",
            "crate::gpu",
            "crate::reference",
        ],
    ),
    Never(
        "renderer-core/src/optics",
        &[
            "crate::render",
            "crate::transport",
            "crate::cpu",
            "crate::gpu",
            "crate::reference",
        ],
    ),
    Never(
        "renderer-core/src/transport",
        &["crate::cpu", "crate::gpu", "crate::reference"],
    ),
    Never("renderer-core/src/cpu", &["crate::gpu", "crate::reference"]),
    Never("renderer-core/src/gpu", &["crate::cpu", "crate::reference"]),
    Never("renderer-core/src/reference", &["crate::cpu", "crate::gpu"]),
    Never(
        "renderer-core/src",
        &["towel_designer", "towel_benches", "egui"],
    ),
    Never("app/src", &["towel_benches"]),
    Only("app/src/designer/widgets", &["designer::widgets"]),
    // How numbers and units are read is not about towels.
    OnlyOf(
        "app/src/designer/widgets",
        "renderer_core",
        &["renderer_core::design::read_number"],
    ),
];

/// The one folder of renderer-core that knows the device.
const GPU: &str = "renderer-core/src/gpu";

/// Words and signs of a text of Rust, without what comments and strings hold.
fn tokens(text: &str) -> Vec<String> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens: Vec<String> = Vec::new();
    for line in text.lines() {
        let (mut in_string, mut before) = (false, ' ');
        for c in line.split("//").next().unwrap_or("").chars() {
            in_string ^= c == '"' && before != '\\' && before != '\'';
            match tokens.last_mut() {
                _ if in_string => {}
                Some(last) if is_word(c) && is_word(before) || c == ':' && before == ':' => {
                    last.push(c);
                }
                _ if !c.is_whitespace() => tokens.push(c.into()),
                _ => {}
            }
            before = c;
        }
    }
    tokens
}

/// Appends the paths of the path or `use` tree that begins at a token, and returns the place behind it.
fn paths_at(tokens: &[String], at: usize, before: &str, paths: &mut Vec<String>) -> usize {
    let is = |at: usize, sign: &str| tokens.get(at).is_some_and(|token| token == sign);
    let begins = |at: usize| {
        let word = tokens
            .get(at)
            .is_some_and(|t| t.starts_with(|c: char| c.is_alphabetic() || c == '_'));
        word || is(at, "{")
    };
    if is(at, "{") {
        let mut at = at + 1;
        while at < tokens.len() && !is(at, "}") {
            at = if begins(at) {
                paths_at(tokens, at, before, paths)
            } else {
                at + 1
            };
        }
        return at + 1;
    }
    let path = format!("{before}{}", tokens[at]);
    if is(at + 1, "::") && begins(at + 2) {
        return paths_at(tokens, at + 2, &(path + "::"), paths);
    }
    paths.push(path);
    at + 1
}

/// The paths that a file names, those of its own crate from `crate` on.
fn named(file: &str, text: &str) -> Vec<String> {
    let tokens = tokens(text);
    let mut paths = Vec::new();
    for (at, pair) in tokens.windows(2).enumerate() {
        if pair[1] == "::" && (at == 0 || tokens[at - 1] != "::") {
            paths_at(&tokens, at, "", &mut paths);
        }
    }
    let (_, module) = file.split_once("/src/").unwrap_or(("", file));
    let mut module: Vec<&str> = module.trim_end_matches(".rs").split('/').collect();
    if matches!(module.last(), Some(&("mod" | "lib" | "main"))) {
        module.pop();
    }
    for path in &mut paths {
        let up = path.split("::").take_while(|&part| part == "super").count();
        if up > 0 {
            let above = &module[..module.len().saturating_sub(up)];
            let rest: Vec<&str> = path.split("::").skip(up).collect();
            *path = [&["crate"], above, &rest].concat().join("::");
        }
    }
    paths
}

/// The arrows of a file that must not be.
fn forbidden(file: &str, text: &str) -> Vec<String> {
    let below = |folder: &str| Path::new(file).starts_with(folder);
    let is_in = |path: &str, other: &str| {
        let rest = path.strip_prefix(other);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
    };
    let breaks = |path: &str, rule: &Arrows| match rule {
        Never(folder, never) => below(folder) && never.iter().any(|other| is_in(path, other)),
        OnlyOf(folder, other, only) => {
            below(folder) && is_in(path, other) && !only.iter().any(|only| is_in(path, only))
        }
        Only(folder, only) => {
            let own = path.strip_prefix("crate::");
            below(folder) && own.is_some_and(|own| !only.iter().any(|other| is_in(own, other)))
        }
    };
    let device = |path: &str| below("renderer-core/src") && !below(GPU) && is_in(path, "wgpu");
    named(file, text)
        .into_iter()
        .filter(|path| device(path) || RULES.iter().any(|rule| breaks(path, rule)))
        .map(|path| format!("{file} names {path}"))
        .collect()
}

/// All Rust files below a folder.
fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn modules_name_only_what_they_may() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for folder in ["renderer-core/src", "app/src"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 200, "{} files", files.len());
    let mut wrong = Vec::new();
    for path in files {
        let file = path
            .strip_prefix(&root)
            .unwrap()
            .to_string_lossy()
            .replace('\\', "/");
        wrong.extend(forbidden(&file, &fs::read_to_string(&path).unwrap()));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_forbidden_arrow_would_be_found() {
    for (file, text) in [
        (
            "renderer-core/src/scene/lod/plan.rs",
            "use crate::render::Settings;",
        ),
        (
            "renderer-core/src/scene/compile.rs",
            "use crate::{design::Design, render::{self, Settings}};",
        ),
        (
            "renderer-core/src/scene/grid/mod.rs",
            "use super::super::{\n    design::Design,\n    render,\n};",
        ),
        (
            "renderer-core/src/scene/mod.rs",
            "fn f(a: &super::render::Settings) {}",
        ),
        (
            "renderer-core/src/cpu/walk.rs",
            "let a = crate::reference::first();",
        ),
        (
            "renderer-core/src/design/form.rs",
            "use crate::{\n    design::Design,\n    scene::Scene,\n};",
        ),
        (
            "renderer-core/src/render/mod.rs",
            "let limits = wgpu::Limits::default();",
        ),
        (
            "app/src/designer/widgets/row.rs",
            "use crate::designer::document::Document;",
        ),
        (
            "app/src/designer/widgets/row.rs",
            "use renderer_core::design::Design;",
        ),
    ] {
        assert_ne!(
            forbidden(file, text),
            Vec::<String>::new(),
            "{file}: {text}"
        );
    }
    for (file, text) in [
        (
            "renderer-core/src/scene/mod.rs",
            "// crate::render::A\n/// [`crate::render`]\nuse crate::design::A;",
        ),
        (
            "renderer-core/src/scene/mod.rs",
            "let text = \"crate::render::Settings\";",
        ),
        (
            "renderer-core/src/scene/lod/plan.rs",
            "use super::render::A;",
        ),
        (
            "renderer-core/src/gpu/context.rs",
            "let limits = wgpu::Limits::default();",
        ),
        (
            "renderer-core/src/cpu/walk.rs",
            "use crate::render::reference::A;",
        ),
    ] {
        assert_eq!(forbidden(file, text), Vec::<String>::new());
    }
}
