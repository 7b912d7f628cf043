-- A mastery rule by a learning curve: its parameters, weights and lines as JSON, computed once at publication. Where it
-- is absent, passes among attempts decide; where it is there, `mastery_passes` and `mastery_of` are 0.
ALTER TABLE curriculum_revisions ADD COLUMN mastery_curve TEXT;
