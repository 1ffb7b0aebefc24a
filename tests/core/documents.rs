//! What comments and documents cite exists: files, sections of MODEL.md, links of Markdown.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Endings of files that cite and are cited.
const CITED: [&str; 3] = [".rs", ".wgsl", ".md"];

/// Everything in the repository that a person wrote, by path from its top.
struct Tree {
    top: PathBuf,
    files: BTreeSet<String>,
}

impl Tree {
    fn new() -> Self {
        let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut files = BTreeSet::new();
        for folder in [
            "app",
            "renderer-core",
            "shaders",
            "tests",
            "presets",
            ".ci",
            ".github",
        ] {
            add_files(&top.join(folder), folder, &mut files);
        }
        files.insert("README.md".into());
        Self { top, files }
    }

    fn text(&self, path: &str) -> String {
        fs::read_to_string(self.top.join(path)).unwrap()
    }

    /// Files with one of these endings, each with its text.
    fn texts(&self, endings: &[&str]) -> Vec<(&str, String)> {
        let wanted = |path: &&String| endings.iter().any(|ending| path.ends_with(ending));
        let files = self.files.iter().filter(wanted);
        files.map(|path| (path.as_str(), self.text(path))).collect()
    }

    /// Whether a path, or the end of one, is a file's.
    fn has(&self, cited: &str) -> bool {
        let end = format!("/{cited}");
        let mut files = self.files.iter();
        files.any(|path| path == cited || path.ends_with(&end))
    }
}

fn add_files(folder: &Path, name: &str, files: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{name}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            add_files(&entry.path(), &path, files);
        } else {
            files.insert(path);
        }
    }
}

/// Words of a text that are names of files. Markdown counts in capitals only: other names are those of files that
/// programs write.
fn cited_files(text: &str) -> impl Iterator<Item = &str> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_./-".contains(c);
    let words = text.split(move |c| !is_part(c));
    let words = words.map(|word| {
        word.trim_end_matches('.')
            .trim_start_matches("../")
            .trim_start_matches("./")
    });
    words.filter(|word| {
        let stem = CITED.iter().find_map(|ending| word.strip_suffix(ending));
        stem.is_some_and(|stem| {
            let name = stem.rsplit('/').next().unwrap_or_default();
            let is_written = word.ends_with(".md") && name.chars().any(char::is_lowercase);
            !name.is_empty() && !is_written
        })
    })
}

/// Numbers of sections that a text cites after "MODEL.md": one, or several joined by nothing but commas, "and" and
/// "to".
fn cited_sections(text: &str) -> Vec<u32> {
    let mut sections = Vec::new();
    for after in text.split("MODEL.md").skip(1) {
        let mut parts = after.split('§');
        let mut between = parts.next().unwrap_or_default();
        for part in parts {
            if !["", ",", "and", "to", ", "].contains(&between.trim()) {
                break;
            }
            let digits = part.len() - part.trim_start_matches(|c: char| c.is_ascii_digit()).len();
            sections.extend(part[..digits].parse::<u32>());
            between = &part[digits..];
        }
    }
    sections
}

/// The comment of a line of Rust or WGSL: from the first `//` that is in no string.
fn comment(line: &str) -> &str {
    let mut starts = line.match_indices("//").map(|(start, _)| start);
    let start = starts.find(|&start| line[..start].matches('"').count().is_multiple_of(2));
    start.map_or("", |start| &line[start..])
}

/// What a text cites that is nowhere, one line each.
fn dead_citations(tree: &Tree, sections: &BTreeSet<u32>, name: &str, text: &str) -> Vec<String> {
    let is_code = !name.ends_with(".md");
    let mut dead = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let text = if is_code { comment(line) } else { line };
        let files = cited_files(text).filter(|file| !tree.has(file));
        dead.extend(files.map(|file| format!("{name}:{number}: there is no {file}")));
        let unknown = cited_sections(text).into_iter();
        let unknown = unknown.filter(|section| !sections.contains(section));
        dead.extend(unknown.map(|section| format!("{name}:{number}: MODEL.md has no §{section}")));
    }
    dead
}

/// Numbers of the model's headings, "## 9. Estimators".
fn sections_of(model: &str) -> BTreeSet<u32> {
    let headings = model.lines().filter_map(|line| line.strip_prefix("## "));
    headings
        .filter_map(|heading| heading.split_once('.')?.0.parse().ok())
        .collect()
}

#[test]
fn files_and_sections_that_are_cited_exist() {
    let tree = Tree::new();
    let sections = sections_of(&tree.text("renderer-core/MODEL.md"));
    let texts = tree.texts(&CITED);
    let dead = texts
        .iter()
        .flat_map(|(name, text)| dead_citations(&tree, &sections, name, text));
    let dead: Vec<String> = dead.collect();
    assert!(dead.is_empty(), "{}", dead.join("\n"));

    // It reads what is there: a hundred comments cite the model.
    let cited = texts
        .iter()
        .map(|(_, text)| cited_sections(text).len())
        .sum::<usize>();
    assert!(cited >= 100, "{cited}");
}

#[test]
fn dead_citations_are_found() {
    let tree = Tree::new();
    let sections = BTreeSet::from([1, 9]);
    let dead = |name: &str, text: &str| dead_citations(&tree, &sections, name, text);
    assert_eq!(
        dead(
            "a.rs",
            "// shaders/trace.wgsl, (MODEL.md §1 and §9) and the paper's §77"
        ),
        [""; 0]
    );
    assert_eq!(dead("a.rs", "let name = \"nowhere.rs\";"), [""; 0]);
    assert_eq!(
        dead("a.rs", "let x = 1; // as in scene/nowhere.rs."),
        ["a.rs:1: there is no scene/nowhere.rs"]
    );
    assert_eq!(
        dead("a.wgsl", "\n// shaders/nowhere.wgsl: x"),
        ["a.wgsl:2: there is no shaders/nowhere.wgsl"]
    );
    // The end of a name is not the end of a path.
    assert_eq!(
        dead("a.rs", "/// race.wgsl"),
        ["a.rs:1: there is no race.wgsl"]
    );
    assert_eq!(
        dead("a.md", "`NOWHERE.md`"),
        ["a.md:1: there is no NOWHERE.md"]
    );
    assert_eq!(
        dead("a.rs", "//! (MODEL.md §2)"),
        ["a.rs:1: MODEL.md has no §2"]
    );
    assert_eq!(
        dead("a.rs", "//! MODEL.md §1, §10 and §11"),
        ["a.rs:1: MODEL.md has no §10", "a.rs:1: MODEL.md has no §11"]
    );
    assert_eq!(
        sections_of("# 3. no\n## 1. One\n### 4. no\n## 12. Twelve\n## Gaps"),
        BTreeSet::from([1, 12])
    );
}

/// Every "§" of the model's page is one of its own, but for those of the paper.
#[test]
fn the_model_cites_its_own_sections() {
    let model = Tree::new().text("renderer-core/MODEL.md");
    let sections = sections_of(&model);
    let own = model
        .replace("paper's §", "paper's ")
        .replace(", §7, figure 10)", ")");
    let mut cited = Vec::new();
    for part in own.split('§').skip(1) {
        let digits = part.len() - part.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        cited.extend(part[..digits].parse::<u32>());
    }
    assert!(cited.len() > 10, "{cited:?}");
    assert!(
        cited.iter().all(|section| sections.contains(section)),
        "{cited:?}"
    );
}

/// Links of a Markdown text that lead nowhere. `exists` tells of a path from the text's folder, `anchors` which
/// headings the file there has; of the text itself for the empty path.
fn dead_links(
    text: &str,
    exists: impl Fn(&str) -> bool,
    anchors: impl Fn(&str) -> BTreeSet<String>,
) -> Vec<String> {
    let mut dead = Vec::new();
    for after in text.split("](").skip(1) {
        let target = after.split([')', ' ']).next().unwrap_or_default();
        if target.contains("://") {
            continue;
        }
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        let leads_somewhere = path.is_empty() || exists(path);
        if !leads_somewhere || !anchor.is_empty() && !anchors(path).contains(anchor) {
            dead.push(target.to_owned());
        }
    }
    dead
}

/// Names that headings have in links.
fn anchors_of(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words
            .chars()
            .filter(|c| c.is_alphanumeric() || "-_ ".contains(*c));
        kept.collect::<String>().replace(' ', "-")
    };
    headings.map(anchor).collect()
}

#[test]
fn links_of_documents_lead_somewhere() {
    let tree = Tree::new();
    let mut links = BTreeMap::new();
    for (name, text) in tree.texts(&[".md"]) {
        let folder = tree.top.join(name).parent().unwrap().to_owned();
        let anchors = |path: &str| match path {
            "" => anchors_of(&text),
            path => anchors_of(&fs::read_to_string(folder.join(path)).unwrap_or_default()),
        };
        let dead = dead_links(&text, |path| folder.join(path).exists(), anchors);
        assert!(dead.is_empty(), "{name}: {dead:?}");
        links.insert(name, text.matches("](").count());
    }
    assert!(
        links["README.md"] > 10 && links["presets/README.md"] > 20,
        "{links:?}"
    );
    assert!(tree.text("README.md").lines().count() <= 200);
}

#[test]
fn links_that_lead_nowhere_are_found() {
    let exists = |path: &str| path == "there.md";
    let anchors = |_: &str| anchors_of("# Two words, §3\ntext\n## Other");
    let dead = |text: &str| dead_links(text, exists, anchors);
    let none: [&str; 0] = [];
    assert_eq!(
        dead("[a](there.md) [b](https://there.is/none) [c](#other) [d](there.md#two-words-3)"),
        none
    );
    assert_eq!(
        dead("![a](gone.png) [b](there.md#gone) [c](#gone)"),
        ["gone.png", "there.md#gone", "#gone"]
    );
}
