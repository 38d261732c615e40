"""ROS glue shared by all floornav nodes; nothing outside this folder and nodes imports it."""
