//! The ways in which a scene's file can be wrong.

/// What is wrong with a scene. Places are as `object 2 (chair), motion 3`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneFault {
    /// No JSON.
    #[error("no JSON: {0}")]
    Json(String),
    /// A longer file than any scene is.
    #[error("the file has more than {0} bytes")]
    Long(u64),
    /// Something that must be an object.
    #[error("{place} is {found}, expected a JSON object")]
    NotObject {
        /// What.
        place: String,
        /// What is there.
        found: String,
    },
    /// A key that must be there.
    #[error("{place} has no \"{key}\"")]
    Missing {
        /// What is without it.
        place: String,
        /// The key.
        key: &'static str,
    },
    /// A key that means nothing there.
    #[error("{place} has a \"{key}\"; it takes {known}")]
    Unknown {
        /// What has it.
        place: String,
        /// The key.
        key: String,
        /// Those that mean something.
        known: String,
    },
    /// A value that is none.
    #[error("{place}: \"{key}\" is {found}, expected {expected}")]
    Value {
        /// What has it.
        place: String,
        /// The key.
        key: &'static str,
        /// What is there.
        found: String,
        /// What must be there.
        expected: String,
    },
    /// Two objects of one name.
    #[error("two objects are called {0}; give one of them a \"name\"")]
    Twice(String),
    /// Two turns of one place.
    #[error("{0} has both \"turn\" and \"rotation\"; give one of them")]
    TwoTurns(String),
    /// A field of an object that casts nothing.
    #[error("{0} has a \"field\" and \"casts\" false; give one of them")]
    FieldUnused(String),
    /// A material that is none.
    #[error("{place}: \"material\": {what}")]
    Material {
        /// What has it.
        place: String,
        /// What is wrong with it.
        what: String,
    },
    /// The light.
    #[error("the light: {0}")]
    Light(String),
}
