-- Who signs certificates and transcripts on paper. Schools of before have named nobody: an empty name.
ALTER TABLE schools ADD COLUMN signatory_name TEXT COLLATE "C" NOT NULL DEFAULT '';
ALTER TABLE schools ADD COLUMN signatory_function TEXT COLLATE "C" NOT NULL DEFAULT '';
