//! The images of a study on its page: examples of errors, the variants after equal times, the noise of each pixel.
//!
//! Measure: errors as roots of relMSE; colours of errors on one scale for all images.
//! Range: any findings; images that were not rendered are left out.
//! Source: none needed. Tested in `cli/tests/command/study.rs` and below.

use super::Findings;
use super::wording::{percent, round_up, samples, seconds};
use crate::report::false_colour::{map, sequential, signed};
use crate::report::page::figure;
use etendue::internals::image::Image;
use etendue_lab::study::shown_images::ImageWithError;
use maud::{Markup, html};

/// The largest sides of a crop, in pixels: so that single pixels can be seen.
const CROP: (u32, u32) = (120, 90);

/// Builds the row of crops of images with different errors.
pub fn examples(findings: &Findings<'_>) -> Markup {
    let all = &findings.report.images;
    let size = (findings.report.size, findings.report.full_size);
    html! {
        @if !all.examples.is_empty() {
            h3 { "What errors look like" }
            div.crops {
                @for shown in &all.examples {
                    @let time = seconds(time_of(findings, shown));
                    (figure(&format!("{} error", percent(shown.rel_mse.max(0.0).sqrt())), &format!("after {time}"), &crop(&shown.image)))
                }
                @if let (Some(reference), Some(told)) = (&all.reference, &findings.report.reference) {
                    // The mean of two has half of the squared error of one.
                    @let error = (0.5 * told.noise.rel_mse).sqrt();
                    (figure(&format!("{} error", percent(error)), "the reference", &crop(reference)))
                }
            }
            @if size.0 != size.1 { p.caption { "Crops of images of " (size.0.0) " × " (size.0.1) " pixels." } }
        }
    }
}

/// The time of an image at the scene's own size.
fn time_of(findings: &Findings<'_>, shown: &ImageWithError) -> f64 {
    let found = findings
        .summaries
        .iter()
        .find(|(index, _)| *index == shown.variant);
    found.map_or(shown.seconds, |(_, summary)| {
        summary.own_time.at(shown.spp as f64)
    })
}

/// The middle of an image.
fn crop(image: &Image) -> Image {
    let (width, height) = (image.width().min(CROP.0), image.height().min(CROP.1));
    let (x0, y0) = ((image.width() - width) / 2, (image.height() - height) / 2);
    let rows = (y0..y0 + height).flat_map(|y| (x0..x0 + width).map(move |x| (x, y)));
    Image::new(width, height, rows.map(|(x, y)| image.get(x, y)).collect())
}

/// Builds the images of the variants after equal times, and the noise of each pixel.
pub fn images(findings: &Findings<'_>) -> Markup {
    let all = &findings.report.images;
    let Some(reference) = &all.reference else {
        return html! { p.caption { "No reference was rendered." } };
    };
    let shown = all.at_times.iter().flat_map(|it| &it.shown);
    let mut errors: Vec<f64> = shown.map(|shown| shown.rel_mse.max(0.0).sqrt()).collect();
    errors.sort_by(f64::total_cmp);
    // All error maps share one scale, which is chosen so that typical errors of the median image have visible colour.
    let middle = errors.get(errors.len() / 2).copied().unwrap_or(1.0);
    let end = round_up(2.0 * middle).min(1.0);
    html! {
        p.caption { "The rendered images that take nearly these times, within a factor of two, at the scene's own size. Beside each its relative error: blue is too dark, red too bright, full colour is "
            (percent(end)) " or more of the pixel's value." }
        @for at in &all.at_times {
            h3 { "After about " (seconds(at.seconds)) }
            div.pairs { @for shown in &at.shown { (pair(findings, shown, end)) } }
        }
        h3 { "The reference" }
        div.figures { (figure("reference", "mean of two renders", reference)) }
        (standard_errors(findings, reference))
    }
}

fn pair(findings: &Findings<'_>, shown: &ImageWithError, end: f64) -> Markup {
    let name = &findings.report.variants[shown.variant].variant.name;
    let caption = format!(
        "{} per pixel, {}, error {}",
        samples(shown.spp),
        seconds(time_of(findings, shown)),
        percent(shown.rel_mse.max(0.0).sqrt())
    );
    let size = (shown.image.width(), shown.image.height());
    let errors = map(&shown.errors, size, end, signed);
    html! {
        div.pair {
            (figure(name, &caption, &shown.image))
            (figure(&format!("{name}: error"), "", &errors))
        }
    }
}

fn standard_errors(findings: &Findings<'_>, reference: &Image) -> Markup {
    let all = &findings.report.images.standard_errors;
    let mut largest: Vec<f64> = all.iter().flat_map(|(_, errors)| errors).copied().collect();
    largest.sort_by(f64::total_cmp);
    // The scale ends at the 90 % quantile of the standard errors.
    let end = largest.get(largest.len() * 9 / 10).copied().unwrap_or(1.0);
    let end = round_up(end);
    let size = (reference.width(), reference.height());
    html! {
        @if !all.is_empty() {
            h3 { "Noise of each pixel" }
            p.caption { "The standard error of each pixel, as estimated by the renderer: dark is none, yellow "
                (percent(end)) " or more of the pixel's value." }
            div.figures {
                @for (index, errors) in all {
                    @let study = &findings.report.variants[*index];
                    @let caption = study.bars.as_ref().map_or(String::new(), |bars| {
                        format!("{} per pixel; {} of the pixels are flagged", samples(bars.spp), percent(bars.flagged))
                    });
                    (figure(&study.variant.name, &caption, &map(errors, size, end, sequential)))
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::internals::math::rgb::Rgb;

    #[test]
    fn crops_are_centred_and_small_images_stay_whole() {
        let image = |width: u32, height: u32| {
            let pixels = (0..width * height).map(|i| Rgb::grey(i as f32));
            Image::new(width, height, pixels.collect())
        };
        let small = image(6, 4);
        assert_eq!(crop(&small).pixels(), small.pixels());
        let cut = crop(&image(220, 95));
        assert_eq!((cut.width(), cut.height()), CROP);
        assert_eq!(cut.get(0, 0), Rgb::grey((2 * 220 + 50) as f32));
    }
}
