//! What commands take that draw and export runs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::RunArguments;

/// Draw a robot, a case, a rig or a run of the rig from its file, with frames, links, hinges, outlines, mount and arm
///
/// The folder holds figures/show.svg and .png, and manifest.json. FILE is a robot, a scenario (its robot at the start), a
/// case (its wing), a rig, or a run (its arm in the middle of the steady turn).
#[derive(Debug, Args)]
pub struct Show {
    /// Robot, scenario, case, rig or run
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Phase of the gait of a robot, scenario or case, rad, where files of cases count cycles of 2 pi; without it that of the start
    #[arg(long, value_name = "RAD", allow_hyphen_values = true)]
    pub phase: Option<f64>,
    /// Joint positions of the arm, deg; without them those of the run's plan, else all zero
    #[arg(long, value_name = "J1,J2,...", value_delimiter = ',', allow_hyphen_values = true)]
    pub joints_deg: Option<Vec<f64>>,
    #[command(flatten)]
    pub run: RunArguments,
}

/// Draw the figures of the paper by our numbers, with one sheet of what it says and what came out here
///
/// Flies the banking turn and the turn on the paper's own joints, simulates and processes the seven runs of the rig, steps the wake
/// of the turn and draws set-up, arm, forces and moments, wake, states and path. The folder holds sheet.html with all of them inside,
/// figures, summary.json with every statement and its verdict, manifest.json, and the run folders turn, clear, rig and forces.
#[derive(Debug, Args)]
pub struct PaperArguments {
    /// The folder with the shipped scenarios, robots and rigs
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub from: PathBuf,
    /// Also draw every figure on a page of 16 to 9 for slides, into figures/wide
    #[arg(long)]
    pub wide: bool,
    /// Folder of the run; without it runs/paper, or runs/paper-2 and so on when that is taken
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the run that --out names, if nothing else lies there
    #[arg(long, requires = "out")]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// Show runs on one page that moves, from their run folders
///
/// The page is one file that needs no network: the run in space, plots beside it, numbers and settings. Of several runs it shows all at
/// once. Without --out the page of one run becomes report.html in its folder, as every run writes it, and that of several runs
/// report.html in the present folder. More in docs/report.md.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Run folders
    #[arg(value_name = "RUN", required = true)]
    pub runs: Vec<PathBuf>,
    /// The page; without it report.html in the folder of the run, or of several runs in the present folder
    #[arg(long, value_name = "PAGE.html")]
    pub out: Option<PathBuf>,
    /// Replace the file that --out or --sheet names
    #[arg(long)]
    pub force: bool,
    /// Draw the plots that the runs have in common over one another, in place of the page
    #[arg(long, value_name = "FILE.png|FILE.svg", conflicts_with_all = ["out", "no_wake", "no_strips"])]
    pub sheet: Option<PathBuf>,
    /// Leave the wake out
    #[arg(long)]
    pub no_wake: bool,
    /// Leave the forces of the strips out
    #[arg(long)]
    pub no_strips: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// Write a run that moves in space as an animated PNG, or as a sequence of PNG files
///
/// Browsers and GitHub show an animated PNG as a picture that moves. It shows the whole path with the robot enlarged, and the robot near
/// by in a corner. Without --out the file is NAME.png in the present folder. More in docs/report.md.
#[derive(Debug, Args)]
pub struct Animate {
    /// The run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// FILE.png for an animated PNG, else the folder of frame_0000.png and so on; without it NAME.png in the present folder
    #[arg(long, value_name = "FILE.png|DIR")]
    pub out: Option<PathBuf>,
    /// From where the run is seen
    #[arg(long, value_enum, default_value = "whole")]
    pub view: AnimatedView,
    /// Seconds of the run in a second
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true)]
    pub speed: f64,
    /// Frames a second
    #[arg(long, value_name = "HZ", default_value_t = 20.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// Width, px
    #[arg(long, value_name = "PX", default_value_t = 640, value_parser = clap::value_parser!(u32).range(160..=3840))]
    pub width: u32,
    /// A picture of 16:9 in place of 4:3
    #[arg(long)]
    pub wide: bool,
    /// Replace what --out names: the file, or the frames in the folder
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}

/// From where an animation shows a run.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum AnimatedView {
    /// The whole path from behind, and the robot near by in a corner
    Whole,
    /// The robot near by, from behind
    Behind,
    /// The whole path from its right side
    Side,
    /// The whole path from above
    Above,
}

/// Write a run in the files of another program
///
/// Without --out the file is NAME.csv, NAME.npz, NAME.mat, NAME.glb or NAME.mcap, or the folder NAME-vtk, in the present folder; the
/// program prints which. More in docs/report.md.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("format").required(true))]
pub struct Export {
    /// The run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// The record as text with columns
    #[arg(long, group = "format")]
    pub csv: bool,
    /// The record for NumPy, an array for each column
    #[arg(long, group = "format")]
    pub npz: bool,
    /// The record for MATLAB, a variable for each column
    #[arg(long, group = "format")]
    pub mat: bool,
    /// Wings, forces, moments and circulation frame by frame for VTK, ParaView and pyvista: a folder with a list of its files
    #[arg(long, group = "format")]
    pub vtk: bool,
    /// The robot with its animation as binary glTF, z up turned to y up
    #[arg(long, group = "format")]
    pub gltf: bool,
    /// A flight as MCAP for ROS 2, every message in CDR: transforms, robot description, joints, odometry, wrenches by source
    #[arg(long, group = "format")]
    pub mcap: bool,
    /// Where; without it NAME.csv, NAME.npz, NAME.mat, NAME.glb, NAME.mcap or the folder NAME-vtk in the present folder
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Replace the file, or the frames in the folder
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(long)]
    pub quiet: bool,
}
