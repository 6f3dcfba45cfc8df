"""What command lines share: values, texts in two languages, tables and pictures."""
