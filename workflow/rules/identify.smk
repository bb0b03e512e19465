# Identification of the bundled log: rules to come. They add their files to ARTEFACTS, and to CHECKED the names of
# figures whose numbers are compared with the committed ones; their settings get a section in config.schema.yaml.
