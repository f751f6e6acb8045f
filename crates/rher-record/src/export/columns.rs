//! Tables as Parquet files.

use super::error::{ExportError, unwritable};
use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A column and its name.
pub(super) type Named = (&'static str, Column);

/// What is under one name: a value in every row, and none missing.
pub(super) enum Column {
    /// Rows of equally many numbers, one after the other.
    Lists(usize, Vec<f32>),
    /// The same, 64 bits wide in the file.
    WideLists(usize, Vec<f32>),
    Numbers(Vec<f32>),
    /// 64 bits wide in the file.
    WideNumbers(Vec<f32>),
    /// 64 bits wide in the file.
    Integers(Vec<u32>),
    Flags(Vec<bool>),
    /// Lists of a single flag.
    FlagLists(Vec<bool>),
    Texts(Vec<String>),
    /// Lists of a single text.
    TextLists(Vec<String>),
    /// Columns under names of their own.
    Group(Vec<Named>),
}

/// A table that is written row group by row group.
pub(super) struct Table {
    path: PathBuf,
    writer: SerializedFileWriter<File>,
}

impl Table {
    /// Starts a table with columns like these; `note` is a name and a text for its readers.
    pub(super) fn create(
        path: &Path,
        columns: &[Named],
        note: Option<(&str, String)>,
    ) -> Result<Self, ExportError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(unwritable(path))?;
        }
        let file = File::create(path).map_err(unwritable(path))?;
        let writer = begin(file, columns, note).map_err(failed(path))?;
        Ok(Self { path: path.to_owned(), writer })
    }

    /// Adds rows.
    pub(super) fn add(&mut self, columns: &[Named]) -> Result<(), ExportError> {
        let mut add = || {
            let mut rows = self.writer.next_row_group()?;
            for (_, column) in columns {
                fill(&mut rows, column)?;
            }
            rows.close()
        };
        add().map(drop).map_err(failed(&self.path))
    }

    /// Ends the table.
    pub(super) fn finish(self) -> Result<(), ExportError> {
        self.writer.close().map(drop).map_err(failed(&self.path))
    }
}

/// Writes a whole table.
pub(super) fn write_table(
    path: &Path,
    columns: &[Named],
    note: Option<(&str, String)>,
) -> Result<(), ExportError> {
    let mut table = Table::create(path, columns, note)?;
    table.add(columns)?;
    table.finish()
}

fn failed(path: &Path) -> impl Fn(ParquetError) -> ExportError {
    move |error| match error {
        ParquetError::External(source) => match source.downcast() {
            Ok(source) => unwritable(path)(*source),
            Err(source) => {
                let (path, source) = (path.to_owned(), ParquetError::External(source));
                ExportError::Table { path, source }
            }
        },
        source => ExportError::Table { path: path.to_owned(), source },
    }
}

fn begin(
    file: File,
    columns: &[Named],
    note: Option<(&str, String)>,
) -> Result<SerializedFileWriter<File>, ParquetError> {
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Arc::new(Type::group_type_builder("schema").with_fields(fields).build()?);
    let note = note.map(|(name, text)| vec![KeyValue::new(name.to_owned(), text)]);
    let properties = WriterProperties::builder()
        .set_created_by(concat!("rher ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_dictionary_enabled(false)
        .set_key_value_metadata(note)
        .build();
    SerializedFileWriter::new(file, schema, Arc::new(properties))
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
        Column::WideLists(..) => list(primitive("element", Physical::DOUBLE).build()?)?,
        Column::Numbers(_) => primitive(name, Physical::FLOAT).build()?,
        Column::WideNumbers(_) => primitive(name, Physical::DOUBLE).build()?,
        Column::Integers(_) => primitive(name, Physical::INT64).build()?,
        Column::Flags(_) => primitive(name, Physical::BOOLEAN).build()?,
        Column::FlagLists(_) => list(primitive("element", Physical::BOOLEAN).build()?)?,
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
    rows: &mut SerializedRowGroupWriter<'_, File>,
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
            let [there, repeats] = levels(*width, values.len());
            writer.typed::<FloatType>().write_batch(values, Some(&there), Some(&repeats))?;
        }
        Column::WideLists(width, values) => {
            let [there, repeats] = levels(*width, values.len());
            let values = wide(values);
            writer.typed::<DoubleType>().write_batch(&values, Some(&there), Some(&repeats))?;
        }
        Column::Numbers(values) => {
            writer.typed::<FloatType>().write_batch(values, None, None)?;
        }
        Column::WideNumbers(values) => {
            writer.typed::<DoubleType>().write_batch(&wide(values), None, None)?;
        }
        Column::Integers(values) => {
            let values: Vec<i64> = values.iter().copied().map(i64::from).collect();
            writer.typed::<Int64Type>().write_batch(&values, None, None)?;
        }
        Column::Flags(values) => {
            writer.typed::<BoolType>().write_batch(values, None, None)?;
        }
        Column::FlagLists(values) => {
            let [there, repeats] = levels(1, values.len());
            writer.typed::<BoolType>().write_batch(values, Some(&there), Some(&repeats))?;
        }
        Column::Texts(values) => {
            writer.typed::<ByteArrayType>().write_batch(&byte_arrays(values), None, None)?;
        }
        Column::TextLists(values) => {
            let [there, repeats] = levels(1, values.len());
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

/// Every element of a list is there (1); one that begins a row repeats nothing (0).
fn levels(width: usize, values: usize) -> [Vec<i16>; 2] {
    let repeats = (0..values).map(|index| i16::from(index % width > 0)).collect();
    [vec![1; values], repeats]
}

fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(f64::from).collect()
}
