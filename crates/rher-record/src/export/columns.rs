//! Tables as Parquet files.

use super::{ExportError, write};
use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use std::path::Path;
use std::sync::Arc;

/// A column and its name.
pub(super) type Named = (&'static str, Column);

/// What is under one name: a value in every row, and none missing.
pub(super) enum Column {
    /// Rows of equally many numbers, one after the other.
    Lists(usize, Vec<f32>),
    Numbers(Vec<f32>),
    /// 64 bits wide in the file.
    Integers(Vec<u32>),
    Flags(Vec<bool>),
    Texts(Vec<String>),
    /// Lists of a single text.
    TextLists(Vec<String>),
    /// Columns under names of their own.
    Group(Vec<Named>),
}

/// Writes a table; `note` is a name and a text for its readers.
pub(super) fn write_table(
    path: &Path,
    columns: &[Named],
    note: Option<(&str, String)>,
) -> Result<(), ExportError> {
    let bytes = to_bytes(columns, note);
    let bytes = bytes.map_err(|source| ExportError::Table { path: path.to_owned(), source })?;
    write(path, &bytes)
}

fn to_bytes(columns: &[Named], note: Option<(&str, String)>) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?);
    let note = note.map(|(name, text)| vec![KeyValue::new(name.to_owned(), text)]);
    let properties = WriterProperties::builder()
        .set_created_by(concat!("rher ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_dictionary_enabled(false)
        .set_key_value_metadata(note)
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut rows = writer.next_row_group()?;
    for (_, column) in columns {
        fill(&mut rows, column)?;
    }
    rows.close()?;
    writer.into_inner()
}

fn field((name, column): &Named) -> Result<TypePtr, ParquetError> {
    let primitive = |name, physical| {
        Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED)
    };
    let text = |name| {
        primitive(name, Physical::BYTE_ARRAY)
            .with_converted_type(ConvertedType::UTF8)
            .with_logical_type(Some(LogicalType::String))
    };
    let list = |element: Type| {
        let items = Type::group_type_builder("list")
            .with_repetition(Repetition::REPEATED)
            .with_fields(vec![Arc::new(element)])
            .build()?;
        Type::group_type_builder(name)
            .with_repetition(Repetition::REQUIRED)
            .with_converted_type(ConvertedType::LIST)
            .with_logical_type(Some(LogicalType::List))
            .with_fields(vec![Arc::new(items)])
            .build()
    };
    let field = match column {
        Column::Lists(..) => list(primitive("element", Physical::FLOAT).build()?)?,
        Column::Numbers(_) => primitive(name, Physical::FLOAT).build()?,
        Column::Integers(_) => primitive(name, Physical::INT64).build()?,
        Column::Flags(_) => primitive(name, Physical::BOOLEAN).build()?,
        Column::Texts(_) => text(name).build()?,
        Column::TextLists(_) => list(text("element").build()?)?,
        Column::Group(columns) => Type::group_type_builder(name)
            .with_repetition(Repetition::REQUIRED)
            .with_fields(columns.iter().map(self::field).collect::<Result<_, _>>()?)
            .build()?,
    };
    Ok(Arc::new(field))
}

fn fill(
    rows: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    column: &Column,
) -> Result<(), ParquetError> {
    if let Column::Group(columns) = column {
        return columns.iter().try_for_each(|(_, column)| fill(rows, column));
    }
    let Some(mut writer) = rows.next_column()? else {
        return Err(ParquetError::General("more columns than the schema has".to_owned()));
    };
    let byte_arrays = |texts: &[String]| -> Vec<ByteArray> {
        texts.iter().map(|text| ByteArray::from(text.as_str())).collect()
    };
    match column {
        Column::Lists(width, values) => {
            // Every element is there (1); one that begins a row repeats nothing (0).
            let there = vec![1; values.len()];
            let repeats: Vec<i16> =
                (0..values.len()).map(|index| i16::from(index % width > 0)).collect();
            writer.typed::<FloatType>().write_batch(values, Some(&there), Some(&repeats))?;
        }
        Column::Numbers(values) => {
            writer.typed::<FloatType>().write_batch(values, None, None)?;
        }
        Column::Integers(values) => {
            let values: Vec<i64> = values.iter().copied().map(i64::from).collect();
            writer.typed::<Int64Type>().write_batch(&values, None, None)?;
        }
        Column::Flags(values) => {
            writer.typed::<BoolType>().write_batch(values, None, None)?;
        }
        Column::Texts(values) => {
            writer.typed::<ByteArrayType>().write_batch(&byte_arrays(values), None, None)?;
        }
        Column::TextLists(values) => {
            let (there, repeats) = (vec![1; values.len()], vec![0; values.len()]);
            writer.typed::<ByteArrayType>().write_batch(
                &byte_arrays(values),
                Some(&there),
                Some(&repeats),
            )?;
        }
        Column::Group(_) => {}
    }
    writer.close()
}
