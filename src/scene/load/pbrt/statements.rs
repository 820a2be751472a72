//! Reads the statements of a pbrt file.
//!
//! Measure: as in the file; matrices are column by column.
//! Range: the statements of pbrt-v4. Anything else is an error that names the line.
//! Source: pbrt-v4's file format. Tested in `tests/loading/pbrt/`.

use super::parameter::{self, Parameter, declared, number, quote};
use super::tokens::{Token, Tokens};
use crate::math::vec::{DAffine3, DMat3, DVec3};
use crate::scene::load::wording::{LineError, unknown_name};
use std::rc::Rc;

/// A statement.
#[derive(Debug)]
pub enum Statement {
    Identity,
    Translate(DVec3),
    Scale(DVec3),
    Rotate {
        /// The angle, in degrees.
        angle: f64,
        axis: DVec3,
    },
    LookAt {
        eye: DVec3,
        target: DVec3,
        up: DVec3,
    },
    Transform(DAffine3),
    ConcatTransform(DAffine3),
    CoordinateSystem(String),
    CoordSysTransform(String),
    /// Whether the transforms at the start and at the end are active.
    ActiveTransform([bool; 2]),
    TransformTimes([f64; 2]),
    AttributeBegin,
    AttributeEnd,
    Attribute(String, Vec<Rc<Parameter>>),
    ReverseOrientation,
    ObjectBegin(String),
    ObjectEnd,
    ObjectInstance(String),
    WorldBegin,
    Include(String),
    Import(String),
    ColorSpace(String),
    NamedMaterial(String),
    MediumInterface,
    Option(String, String),
    Texture {
        name: String,
        /// `float` or `spectrum`.
        value_type: String,
        class: String,
        parameters: Vec<Rc<Parameter>>,
    },
    /// A statement of a name and parameters.
    Entity(Entity, String, Vec<Rc<Parameter>>),
}

/// The statements that consist of a name and parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entity {
    Accelerator,
    AreaLightSource,
    Camera,
    Film,
    Integrator,
    LightSource,
    MakeNamedMaterial,
    MakeNamedMedium,
    Material,
    PixelFilter,
    Sampler,
    Shape,
}

impl Entity {
    const ALL: &'static [(&'static str, Self)] = &[
        ("Accelerator", Self::Accelerator),
        ("AreaLightSource", Self::AreaLightSource),
        ("Camera", Self::Camera),
        ("Film", Self::Film),
        ("Integrator", Self::Integrator),
        ("LightSource", Self::LightSource),
        ("MakeNamedMaterial", Self::MakeNamedMaterial),
        ("MakeNamedMedium", Self::MakeNamedMedium),
        ("Material", Self::Material),
        ("PixelFilter", Self::PixelFilter),
        ("Sampler", Self::Sampler),
        ("Shape", Self::Shape),
    ];

    /// Whether it may only stand before `WorldBegin`.
    pub fn is_option(self) -> bool {
        matches!(
            self,
            Self::Accelerator
                | Self::Camera
                | Self::Film
                | Self::Integrator
                | Self::PixelFilter
                | Self::Sampler
        )
    }

    /// The name of the statement.
    pub fn name(self) -> &'static str {
        let found = Self::ALL.iter().find(|(_, entity)| *entity == self);
        found.map_or("", |(name, _)| name)
    }
}

/// The names of all other statements.
const OTHERS: &[&str] = &[
    "ActiveTransform",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Identity",
    "Import",
    "Include",
    "LookAt",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "ReverseOrientation",
    "Rotate",
    "Scale",
    "Texture",
    "Transform",
    "TransformBegin",
    "TransformEnd",
    "TransformTimes",
    "Translate",
    "WorldBegin",
];

type Read<T> = Result<T, LineError>;

/// Reads the next statement and its line; `None` at the end of the text.
///
/// # Errors
/// The line and what was expected there.
pub fn next(tokens: &mut Tokens<'_>) -> Read<Option<(Statement, usize)>> {
    let Some((token, line)) = tokens.next()? else {
        return Ok(None);
    };
    let Token::Word(word) = token else {
        return Err((
            line,
            format!("expected a statement, found {}", quote(Some(&token))),
        ));
    };
    if let Some((_, entity)) = Entity::ALL.iter().find(|(name, _)| *name == word) {
        let name = text(tokens)?;
        let statement = Statement::Entity(*entity, name, parameter::read(tokens)?);
        return Ok(Some((statement, line)));
    }
    let statement = match word {
        "Identity" => Statement::Identity,
        "Translate" => Statement::Translate(vector(tokens)?),
        "Scale" => Statement::Scale(vector(tokens)?),
        "Rotate" => Statement::Rotate {
            angle: one(tokens)?,
            axis: vector(tokens)?,
        },
        "LookAt" => Statement::LookAt {
            eye: vector(tokens)?,
            target: vector(tokens)?,
            up: vector(tokens)?,
        },
        "Transform" => Statement::Transform(matrix(tokens)?),
        "ConcatTransform" => Statement::ConcatTransform(matrix(tokens)?),
        "CoordinateSystem" => Statement::CoordinateSystem(text(tokens)?),
        "CoordSysTransform" => Statement::CoordSysTransform(text(tokens)?),
        "ActiveTransform" => Statement::ActiveTransform(active(tokens)?),
        "TransformTimes" => Statement::TransformTimes([one(tokens)?, one(tokens)?]),
        // pbrt-v4 takes the older names of attribute blocks, too.
        "AttributeBegin" | "TransformBegin" => Statement::AttributeBegin,
        "AttributeEnd" | "TransformEnd" => Statement::AttributeEnd,
        "Attribute" => Statement::Attribute(text(tokens)?, parameter::read(tokens)?),
        "ReverseOrientation" => Statement::ReverseOrientation,
        "ObjectBegin" => Statement::ObjectBegin(text(tokens)?),
        "ObjectEnd" => Statement::ObjectEnd,
        "ObjectInstance" => Statement::ObjectInstance(text(tokens)?),
        "WorldBegin" => Statement::WorldBegin,
        "Include" => Statement::Include(text(tokens)?),
        "Import" => Statement::Import(text(tokens)?),
        "ColorSpace" => Statement::ColorSpace(text(tokens)?),
        "NamedMaterial" => Statement::NamedMaterial(text(tokens)?),
        "MediumInterface" => medium_interface(tokens)?,
        "Option" => option(tokens)?,
        "Texture" => Statement::Texture {
            name: text(tokens)?,
            value_type: text(tokens)?,
            class: text(tokens)?,
            parameters: parameter::read(tokens)?,
        },
        _ => {
            let entities = Entity::ALL.iter().map(|(name, _)| *name);
            let known: Vec<&str> = entities.chain(OTHERS.iter().copied()).collect();
            return Err((line, unknown_name("statement", word, &known)));
        }
    };
    Ok(Some((statement, line)))
}

/// Reads a string in quotes.
fn text(tokens: &mut Tokens<'_>) -> Read<String> {
    let line = tokens.line();
    match tokens.next()? {
        Some((Token::Quoted(text), _)) => Ok(text.into_owned()),
        Some((other, line)) => Err((
            line,
            format!("expected a string in quotes, found {}", quote(Some(&other))),
        )),
        None => Err((
            line,
            "expected a string in quotes, found the end of the file".to_owned(),
        )),
    }
}

fn one(tokens: &mut Tokens<'_>) -> Read<f64> {
    let line = tokens.line();
    match tokens.next()? {
        Some((Token::Word(word), line)) => number(word).map_err(|why| (line, why)),
        Some((other, line)) => Err((
            line,
            format!("expected a number, found {}", quote(Some(&other))),
        )),
        None => Err((
            line,
            "expected a number, found the end of the file".to_owned(),
        )),
    }
}

fn vector(tokens: &mut Tokens<'_>) -> Read<DVec3> {
    Ok(DVec3::new(one(tokens)?, one(tokens)?, one(tokens)?))
}

/// Reads sixteen numbers in brackets: an affine matrix, column by column.
fn matrix(tokens: &mut Tokens<'_>) -> Read<DAffine3> {
    let line = tokens.line();
    bracket(tokens, &Token::Open)?;
    let mut m = [0.0; 16];
    for entry in &mut m {
        *entry = one(tokens)?;
    }
    bracket(tokens, &Token::Close)?;
    if [m[3], m[7], m[11]] != [0.0; 3] || m[15] == 0.0 {
        let message = "expected an affine matrix, column by column: entries 4, 8 and 12 are 0";
        return Err((line, message.to_owned()));
    }
    let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]) / m[15];
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(column(0), column(1), column(2)),
        translation: column(3),
    })
}

fn bracket(tokens: &mut Tokens<'_>, expected: &Token<'_>) -> Read<()> {
    let line = tokens.line();
    match tokens.next()? {
        Some((token, _)) if token == *expected => Ok(()),
        other => {
            let line = other.as_ref().map_or(line, |(_, line)| *line);
            let found = quote(other.as_ref().map(|(token, _)| token));
            Err((
                line,
                format!(
                    "expected {} around sixteen numbers, found {found}",
                    quote(Some(expected))
                ),
            ))
        }
    }
}

fn active(tokens: &mut Tokens<'_>) -> Read<[bool; 2]> {
    let line = tokens.line();
    let token = tokens.next()?;
    match token.as_ref().map(|(token, _)| token) {
        Some(Token::Word("All")) => Ok([true, true]),
        Some(Token::Word("StartTime")) => Ok([true, false]),
        Some(Token::Word("EndTime")) => Ok([false, true]),
        other => Err((
            line,
            format!("expected All, StartTime or EndTime, found {}", quote(other)),
        )),
    }
}

/// Reads the medium inside and, if given, the one outside.
fn medium_interface(tokens: &mut Tokens<'_>) -> Read<Statement> {
    text(tokens)?;
    if let Some(Token::Quoted(_)) = tokens.peek()? {
        tokens.next()?;
    }
    Ok(Statement::MediumInterface)
}

/// Reads the declaration of an option and its value as text.
fn option(tokens: &mut Tokens<'_>) -> Read<Statement> {
    let line = tokens.line();
    let (_, name) = declared(&text(tokens)?).map_err(|why| (line, why))?;
    match tokens.next()? {
        Some((Token::Word(value), _)) => Ok(Statement::Option(name, value.to_owned())),
        Some((Token::Quoted(value), _)) => Ok(Statement::Option(name, value.into_owned())),
        other => {
            let found = quote(other.as_ref().map(|(token, _)| token));
            Err((
                line,
                format!("expected a value of the option, found {found}"),
            ))
        }
    }
}
