//! Progress on stderr: a bar with time and ETA on a terminal, nothing when quiet or redirected.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar over `total` units. Colours follow NO_COLOR (indicatif honours it).
pub fn bar(total: u64, quiet: bool) -> ProgressBar {
    let target = if quiet {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let bar = ProgressBar::with_draw_target(Some(total), target);
    // The template is a constant; the plain style is a harmless fallback.
    let style = ProgressStyle::with_template(
        "{elapsed_precise} [{bar:28}] {pos}/{len}  eta {eta}  {wide_msg}",
    );
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
