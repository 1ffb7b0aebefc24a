//! What the renderer says is wrong, and what the program says one can do about it where one is.

use renderer_core::design::{Design, Method};
use renderer_core::render::{BackendKind, RenderError};
use renderer_core::scene::CompileError;
use towel_designer::advice::{Place, with_advice, with_advice_on_cloth};

fn errors() -> Vec<RenderError> {
    vec![
        RenderError::NoAdapter("none was found".into()),
        RenderError::BeyondAdapter {
            what: "the picture's width",
            value: 9000,
            limit: 8192,
            adapter: "a card".into(),
        },
        RenderError::Size("no pixels".into()),
        RenderError::Method {
            backend: BackendKind::Gpu,
            method: Method::SixFace,
        },
        RenderError::Device("it stopped".into()),
        RenderError::OutOfMemory("full".into()),
        RenderError::Lost("unplugged".into()),
    ]
}

#[test]
fn the_renderer_states_facts() {
    for error in errors() {
        let fact = error.to_string();
        for word in ["--", "use ", "try ", "install", "choose "] {
            assert!(!fact.contains(word), "{fact}");
        }
    }
    let cloth = CompileError::TooManyEntries { loops: 9, limit: 8 };
    assert!(cloth.to_string().ends_with("exceed 8 entries"), "{cloth}");
}

#[test]
fn advice_is_for_where_one_is() {
    for error in errors() {
        let fact = error.to_string();
        let [line, view, export] = [Place::CommandLine, Place::Viewport, Place::Export]
            .map(|place| with_advice(&error, place));
        for text in [&line, &view, &export] {
            assert!(text.starts_with(&fact), "{text}");
        }
        if matches!(error, RenderError::Size(_)) {
            assert_eq!([&line, &view, &export], [&fact; 3]);
            continue;
        }
        assert!(line.contains("use --backend cpu"), "{line}");
        assert!(
            view.contains("choose the backend cpu in the status bar"),
            "{view}"
        );
        assert!(
            export.contains("choose the backend cpu in the export window"),
            "{export}"
        );
        for text in [view, export] {
            assert!(!text.contains("--"), "a window has no options: {text}");
        }
    }
}

#[test]
fn another_backend_is_one_that_draws_it() {
    let error = RenderError::Method {
        backend: BackendKind::Cpu,
        method: Method::SixFace,
    };
    let text = with_advice(&error, Place::CommandLine);
    assert!(
        text.ends_with("; use --backend reference or another method"),
        "{text}"
    );
}

#[test]
fn cloth_that_cannot_be_made_says_what_helps() {
    let error = CompileError::TooManyEntries { loops: 9, limit: 8 };
    let text = with_advice_on_cloth(&error);
    assert!(
        text.starts_with(&error.to_string()) && text.contains("shorter"),
        "{text}"
    );
    let mut design = Design::default();
    design.pile.tilt = 999.0;
    let error = CompileError::Invalid(design.faults());
    assert_eq!(with_advice_on_cloth(&error), error.to_string());
}
