//! JSON in a text column. It is stored byte for byte, independently of the engine's JSON types,
//! because the audit log hashes it.

use serde::de::Deserialize;
use serde::ser::Serialize;
use sqlx::database::Database as AnyDatabase;
use sqlx::encode::IsNull;
use sqlx::error::BoxDynError;
use sqlx::{Decode, Encode, Type};

/// A value stored as JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Json<T>(pub T);

impl<T> std::ops::Deref for Json<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T> std::ops::DerefMut for Json<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.0
    }
}

impl<T> AsRef<T> for Json<T> {
    fn as_ref(&self) -> &T {
        &self.0
    }
}

impl<T: Serialize> Serialize for Json<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<T, E: AnyDatabase> Type<E> for Json<T>
where
    String: Type<E>,
{
    fn type_info() -> E::TypeInfo {
        String::type_info()
    }

    fn compatible(kind: &E::TypeInfo) -> bool {
        String::compatible(kind)
    }
}

impl<'q, T: Serialize, E: AnyDatabase> Encode<'q, E> for Json<T>
where
    String: Encode<'q, E>,
{
    fn encode_by_ref(&self, arguments: &mut E::ArgumentBuffer) -> Result<IsNull, BoxDynError> {
        serde_json::to_string(&self.0)?.encode(arguments)
    }
}

impl<'r, T: Deserialize<'r>, E: AnyDatabase> Decode<'r, E> for Json<T>
where
    &'r str: Decode<'r, E>,
{
    fn decode(value: E::ValueRef<'r>) -> Result<Self, BoxDynError> {
        Ok(Self(serde_json::from_str(<&str>::decode(value)?)?))
    }
}
