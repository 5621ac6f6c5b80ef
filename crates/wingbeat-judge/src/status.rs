//! What a result is.

use serde::Serialize;

/// What a result is, from the best to the worst. Of several findings the worst is the status.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// No limit is missed but those that only warn.
    Ok,
    /// Nothing that was judged breaks its limit, but what the task asks could not be judged.
    NotJudged,
    /// The task was carried out and missed what it asks.
    OffTarget,
    /// The result lies outside the range in which its model, its fit or its data hold.
    Outside,
    /// The measured data do not say what they are used for.
    SuspectData,
    /// The motion does not repeat, so that its means over a cycle say nothing.
    NotPeriodic,
    /// The result depends on the grid, the step, the iterations or the length.
    NotResolved,
    /// What was searched for was not found.
    NotFound,
    /// The computation or the instrument broke down.
    Failed,
    /// Ended from outside before its end.
    Interrupted,
}

impl Status {
    /// All of them, from the best to the worst.
    pub const ALL: [Self; 10] = [
        Self::Ok,
        Self::NotJudged,
        Self::OffTarget,
        Self::Outside,
        Self::SuspectData,
        Self::NotPeriodic,
        Self::NotResolved,
        Self::NotFound,
        Self::Failed,
        Self::Interrupted,
    ];

    /// As files have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NotJudged => "not_judged",
            Self::OffTarget => "off_target",
            Self::Outside => "outside",
            Self::SuspectData => "suspect_data",
            Self::NotResolved => "not_resolved",
            Self::NotPeriodic => "not_periodic",
            Self::NotFound => "not_found",
            Self::Failed => "failed",
            Self::Interrupted => "interrupted",
        }
    }

    /// What it means, as a sentence without its end.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Ok => "no limit is missed but those that only warn",
            Self::NotJudged => {
                "nothing that was judged breaks its limit, but what the task asks could not be judged"
            }
            Self::OffTarget => "the task was carried out and missed what it asks",
            Self::Outside => "the result lies outside the range in which its model, its fit or its data hold",
            Self::SuspectData => "the measured data do not say what they are used for",
            Self::NotResolved => "the result depends on the grid, the step, the iterations or the length",
            Self::NotPeriodic => "the motion does not repeat, so that its means over a cycle say nothing",
            Self::NotFound => "what was searched for was not found",
            Self::Failed => "the computation or the instrument broke down",
            Self::Interrupted => "the run was ended from outside before its end",
        }
    }

    /// Exit code of a program whose result this is: 0 for `ok` and `not_judged`, 130 for `interrupted`, 3 for all others.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Ok | Self::NotJudged => 0,
            Self::Interrupted => 130,
            _ => 3,
        }
    }
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl Default for Status {
    /// Nothing was found yet.
    fn default() -> Self {
        Self::NotFound
    }
}
