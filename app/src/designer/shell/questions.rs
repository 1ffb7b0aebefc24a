//! Questions with a few answers, before everything else: each answer is a command.

use egui::{Context, Id, Key, Modal, TextEdit};

use crate::designer::shell::command::Command;
use crate::designer::widgets::style;

/// A question.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// What it is about, in a few words.
    pub title: String,
    /// The whole story.
    pub text: String,
    /// A line to type, and what to do with it: goes with the first answer.
    pub line: Option<TextLine>,
    /// Answers and what they do.
    pub answers: Vec<(&'static str, Command)>,
    /// The answer that changes nothing; also given by Escape.
    pub otherwise: (&'static str, Option<Command>),
}

/// What a question was answered.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// Do this.
    Do(Command),
    /// Leave everything as it is.
    Leave,
}

/// A line to type.
#[derive(Debug, Clone, PartialEq)]
pub struct TextLine {
    /// What it is.
    pub name: &'static str,
    /// What is typed.
    pub text: String,
    /// Whether it has got the keyboard.
    pub is_focused: bool,
}

impl Question {
    /// A question that "Cancel" leaves as it was.
    pub fn new(title: impl Into<String>, text: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            text: text.into(),
            line: None,
            answers: Vec::new(),
            otherwise: ("Cancel", None),
        }
    }

    /// With an answer more.
    pub fn answer(mut self, name: &'static str, command: Command) -> Self {
        self.answers.push((name, command));
        self
    }

    /// With a line to type.
    pub fn line(mut self, name: &'static str, text: impl Into<String>) -> Self {
        self.line = Some(TextLine {
            name,
            text: text.into(),
            is_focused: false,
        });
        self
    }

    /// The answer that changes nothing.
    fn no(&self) -> Answer {
        let command = self.otherwise.1.clone();
        command.map_or(Answer::Leave, Answer::Do)
    }

    /// Shows it; the answer once there is one.
    pub fn show(&mut self, ctx: &Context) -> Option<Answer> {
        let mut answer = None;
        let modal = Modal::new(Id::unique("question"))
            .frame(style::dialog(ctx))
            .show(ctx, |ui| {
                ui.set_width(380.0);
                ui.heading(&self.title);
                ui.add_space(4.0);
                if !self.text.is_empty() {
                    ui.label(&self.text);
                }
                let mut is_entered = false;
                if let Some(line) = &mut self.line {
                    ui.add_space(4.0);
                    ui.horizontal(|ui| {
                        let label = ui.label(line.name);
                        let field = TextEdit::singleline(&mut line.text)
                            .desired_width(ui.available_width());
                        let field = ui.add(field).labelled_by(label.id);
                        if !line.is_focused {
                            line.is_focused = true;
                            field.request_focus();
                        }
                        is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
                    });
                }
                let typed = self.line.as_ref().map(|line| line.text.trim());
                let is_possible = typed.is_none_or(|text| !text.is_empty());
                ui.add_space(8.0);
                ui.horizontal_wrapped(|ui| {
                    for (index, (name, command)) in self.answers.iter().enumerate() {
                        let button = ui.add_enabled(is_possible, egui::Button::new(*name));
                        let is_first = index == 0 && is_entered && is_possible;
                        if button.clicked() || is_first {
                            answer = Some(Answer::Do(match typed {
                                Some(text) => command.clone().with_name(text),
                                None => command.clone(),
                            }));
                        }
                    }
                    if ui.button(self.otherwise.0).clicked() {
                        answer = Some(self.no());
                    }
                });
            });
        if modal.should_close() && answer.is_none() {
            answer = Some(self.no());
        }
        answer
    }
}
